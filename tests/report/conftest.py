"""What the tests of reports share: one real browser, and the viewer with its packages.

Without a browser or npm those tests skip and say so.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest
from playwright import sync_api

ROOT = Path(__file__).parents[2]
NPM = shutil.which("npm")
INSTALL = ["ci", "--engine-strict", "--ignore-scripts", "--no-audit", "--no-fund",
           "--prefer-offline", "--fetch-retries=1", "--fetch-retry-mintimeout=1000"]  # fmt: skip
# npm's words for a lock file that does not fit package.json or the packages: not the network.
BROKEN_LOCK = ("EUSAGE", "EINTEGRITY", "EJSONPARSE")
CHROMIUM = (
    shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
)
# Drawn by the processor: there is no graphics card where tests run.
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
         "--disable-background-networking"]  # fmt: skip


@pytest.fixture(scope="session")
def launched():
    """`launched(flags)`: a browser that ends with the tests."""
    if CHROMIUM is None:
        pytest.skip("no Chromium in the path; the page is not tested (apt install chromium)")
    with sync_api.sync_playwright() as playwright:
        browsers = []

        def launch(flags):
            browsers.append(playwright.chromium.launch(executable_path=CHROMIUM, args=flags))
            return browsers[-1]

        yield launch
        for browser in browsers:
            browser.close()


@pytest.fixture(scope="session")
def browser(launched):
    return launched(FLAGS)


@pytest.fixture(scope="module")
def shown_page(browser):
    """`shown_page(path)`: a tab of a usual size in which the page is ready."""
    tabs = []

    def show(path):
        tab = browser.new_page(viewport={"width": 1300, "height": 900})
        tabs.append(tab)
        tab.goto(path.as_uri())
        tab.evaluate("window.sherd.ready")
        return tab

    yield show
    for tab in tabs:
        tab.close()


@pytest.fixture(scope="session")
def npm():
    """Runs npm with some words in a folder; skips where there is none."""
    if NPM is None or shutil.which("node") is None:
        pytest.skip(
            "no node or no npm in the path; what needs them is not tested (install Node.js)"
        )
    program = NPM

    def run(words: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [program, *words], cwd=folder, capture_output=True, text=True, timeout=300, check=False
        )

    return run


@pytest.fixture(scope="session")
def viewer(npm, tmp_path_factory) -> Path:
    """A copy of viewer/ with its packages installed; skips where npm cannot fetch them."""
    folder: Path = tmp_path_factory.mktemp("npm") / "viewer"
    shutil.copytree(ROOT / "viewer", folder, ignore=shutil.ignore_patterns("node_modules"))
    try:
        done = npm(INSTALL, folder)
    except subprocess.TimeoutExpired:
        pytest.skip("npm did not fetch the viewer's packages within five minutes")
    if done.returncode:
        assert not any(f"code {code}" in done.stderr for code in BROKEN_LOCK), done.stderr
        errors = [line for line in done.stderr.splitlines() if line.startswith("npm error")]
        pytest.skip(f"npm cannot fetch the viewer's packages ({'; '.join(errors[:2])})")
    return folder
