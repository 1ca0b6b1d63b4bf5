from __future__ import annotations

import base64
import hashlib
import html
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from sherd.drawing.exhibit import Exhibit, Verdict
from sherd.mesh.triangle_mesh import TriangleMesh
from sherd.report.html import page, write_page
from sherd.report.notebook import show
from sherd.report.payload import Block, unpacked
from sherd.report.thinning import thinned
from sherd.report.tradeoff import share_above

HOSTILE = "</script><script>window.hacked = true</script><img src=x onerror=alert(1)>{{meta}}"


class Elements(HTMLParser):
    """Every start tag with its attributes."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs)))


def _embedded(text: str) -> tuple[dict, str]:
    meta = re.search(r'id="sherd-meta">(.*?)</script>', text, re.DOTALL).group(1)
    data = re.search(r'id="sherd-data">(.*?)</script>', text, re.DOTALL).group(1)
    return json.loads(meta), data


@pytest.fixture(scope="module")
def document(exhibit):
    return page(exhibit)


def test_nothing_is_loaded_from_elsewhere(document):
    elements = Elements(document).found
    for _, attributes in elements:
        for key in ("src", "href", "data", "action", "poster", "srcset"):
            assert (attributes.get(key) or "data:").startswith("data:")
    assert not [
        tag for tag, _ in elements if tag in ("link", "iframe", "object", "base", "form-action")
    ]
    style = re.search(r"<style>(.*?)</style>", document, re.DOTALL).group(1)
    assert "url(" not in style
    assert "@import" not in style
    # the only addresses in the script are XML name spaces
    assert set(re.findall(r"https?://[\w.]+", document)) <= {"http://www.w3.org"}


def test_lists_in_tables_stay_readable(exhibit):
    options = {"landmarks": ((7, 1200), (8, 30)), "ignore": tuple(range(5000)), "none_given": ()}
    text = page(replace(exhibit, facts={"Options": options}))
    for words in ("(7, 1,200), (8, 30)", "5,000 entries", "none"):
        assert f">{words}</td>" in text


def test_security_policy_allows_this_script_only(document):
    policy = next(
        a["content"] for t, a in Elements(document).found if t == "meta" and "http-equiv" in a
    )
    script = re.findall(r"<script>(.*?)</script>", document, re.DOTALL)[-1]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy
    assert "default-src 'none'" in policy


def test_hostile_names_stay_text(exhibit):
    full = TriangleMesh(exhibit.full.vertices, exhibit.full.faces, name=HOSTILE)
    facts = {HOSTILE: {HOSTILE: HOSTILE}}
    words = {"summary": (HOSTILE, HOSTILE), "facts": facts, "command": HOSTILE}
    hostile = Exhibit(HOSTILE, full, exhibit.part, **words)
    text = page(hostile)
    assert "<script>window" not in text
    assert "<img src=x" not in text
    assert text.count(html.escape(HOSTILE)) >= 7
    assert _embedded(text)[0]["shapes"]["full"]["name"] == HOSTILE
    plain = page(Exhibit("t", exhibit.full, exhibit.part))
    assert len(re.findall("<script", text)) == len(re.findall("<script", plain))


def test_numbers_come_back_within_the_quantization(exhibit, document):
    meta, data = _embedded(document)
    shape = meta["shapes"]["full"]
    axes = [unpacked(data, entry) / 65534 for entry in shape["positions"]]
    positions = np.stack(axes, axis=1) * shape["extent"] + shape["low"]
    assert np.abs(positions - exhibit.full.vertices).max() <= 0.51 * shape["extent"] / 65534
    faces = unpacked(data, shape["faces"]).reshape(-1, 3)
    np.testing.assert_array_equal(faces, exhibit.full.faces)
    layer = meta["layers"]["full"][0]
    values = unpacked(data, layer["values"]) / 65534 * (layer["high"] - layer["low"]) + layer["low"]
    assert np.abs(values - exhibit.full_layers[0].values).max() < 1e-5
    mask = unpacked(data, meta["layers"]["full"][2]["values"])
    np.testing.assert_array_equal(mask.astype(bool), exhibit.full_layers[2].values)
    partner = meta["placements"][0]["partner"]
    np.testing.assert_array_equal(unpacked(data, partner["faces"]), exhibit.partner.points.faces)
    np.testing.assert_array_equal(
        unpacked(data, partner["matched"]).astype(bool), exhibit.partner.known
    )
    assert [place["score"] for place in meta["placements"]] == [0.95, 0.71]


@pytest.mark.parametrize("width", [1, 2, 4])
def test_packing_is_exact_for_all_integers(width):
    rng = np.random.default_rng(5)
    top = 2 ** (8 * width)
    values = np.concatenate([[0, top - 1, 0, top - 1], rng.integers(0, top, 500)])
    for delta in (True, False):
        block = Block()
        block.add(np.arange(3), 1)
        entry = block.add(values, width, delta=delta)
        np.testing.assert_array_equal(unpacked(block.packed(), entry), values)


def test_page_repeats_to_the_bit_and_is_small(exhibit_of_size, tmp_path):
    large = exhibit_of_size(5)  # 10,242 and 5,192 vertices
    write_page(large, tmp_path / "report.html")
    size = (tmp_path / "report.html").stat().st_size
    assert size < 2_000_000
    assert (tmp_path / "report.html").read_text(encoding="utf-8") == page(large)


def test_large_shapes_are_decimated_and_the_page_says_so(exhibit_of_size):
    exhibit = exhibit_of_size(4)
    light = thinned(exhibit, largest=1000)
    assert light.exhibit.full.vertex_count <= 1010
    assert light.exhibit.part.vertex_count <= 1010
    numbers = light.full_numbers
    np.testing.assert_array_equal(
        light.exhibit.full_layers[0].values, exhibit.full_layers[0].values[numbers]
    )
    gap = light.exhibit.full.vertices - exhibit.full.vertices[numbers]
    assert np.linalg.norm(gap, axis=1).max() < 2 * exhibit.full.mean_edge_length
    # the map still leads to the same places
    before = exhibit.partner.points.positions(exhibit.full)[light.part_numbers]
    after = light.exhibit.partner.points.positions(light.exhibit.full)
    assert np.linalg.norm(after - before, axis=1).max() < 2 * exhibit.full.mean_edge_length
    text = page(exhibit, largest=1000)
    assert "of the 2,562 vertices of whole.ply" in text
    assert thinned(exhibit).exhibit is exhibit


def test_a_verdict_stands_above_the_headline_in_its_own_color(exhibit_of_size):
    doubt = Verdict("Doubtful", trusted=False, advice=HOSTILE)
    text = page(exhibit_of_size(2, verdict=doubt))
    assert '<p id="verdict" class="doubted"><b>Doubtful</b>' in text
    assert html.escape(HOSTILE) in text
    assert text.index('id="verdict"') < text.index('class="lead"')
    assert _embedded(text)[0]["verdict"]["trusted"] is False
    calm = page(exhibit_of_size(2, verdict=Verdict("Good", trusted=True)))
    assert 'class="trusted"' in calm
    assert "doubted" not in re.search(r"<body>(.*?)<main>", calm, re.DOTALL).group(1)
    assert 'id="verdict"' not in re.search(
        r"<body>(.*?)<main>", page(exhibit_of_size(2)), re.DOTALL
    ).group(1)


def test_the_plot_of_confidence_names_its_axes_and_its_unit(exhibit, document):
    plot = re.search(r'<svg class="plot".*?</svg>', document, re.DOTALL).group(0)
    assert "share of vertices" in plot
    assert "confidence of at least" in plot
    shares = share_above(
        np.asarray(exhibit.partner.confidence), exhibit.partner.known, np.array([0.0, 0.5, 1.0])
    )
    sure = (np.asarray(exhibit.partner.confidence) >= 0.5) & exhibit.partner.known
    assert shares[1] == sure.mean()
    assert shares[0] == exhibit.partner.known.mean()
    assert f"{sure.mean():.0%} are matched" in plot
    assert f"1 sqrt(area) of the full shape is {np.sqrt(exhibit.full.area):.4g}" in document
    assert (
        "tradeoff"
        not in page(Exhibit("t", exhibit.full, exhibit.part)).split("<main>")[1].split("<script")[0]
    )


def test_words_and_tables_stand_in_the_page_itself(document):
    said = ["The part is half of the full shape.", "2 vertices have no partner."]
    for words in (
        *said,
        "sherd match whole.ply piece.ply -o out/",
        "steps, first",
        "unknown",
        "19,568",
    ):
        assert words in document


def test_script_is_ascii_so_that_its_hash_holds_in_any_frame(document):
    script = re.findall(r"<script>(.*?)</script>", document, re.DOTALL)[-1]
    assert script.isascii()


def test_notebook_frame_holds_the_whole_page(exhibit, document):
    shown = show(exhibit)
    frame = re.fullmatch(
        r'<iframe srcdoc="(.*?)" sandbox="allow-scripts allow-downloads" .*',
        shown._repr_html_(),
        re.DOTALL,
    )
    assert html.unescape(frame.group(1)) == document
    assert len(repr(shown)) < 100
