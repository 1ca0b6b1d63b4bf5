"""One real browser for all tests of pages; without one they skip and say so."""

from __future__ import annotations

import shutil

import pytest

CHROMIUM = (
    shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
)
# Drawn by the processor: there is no graphics card where tests run.
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
         "--disable-background-networking"]  # fmt: skip


@pytest.fixture(scope="session")
def launched():
    """`launched(flags)`: a browser that ends with the tests."""
    sync_api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
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
