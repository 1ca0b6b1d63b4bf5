"""The page of a batch: self-contained, small, safe."""

from __future__ import annotations

import base64
import json
import re

import numpy as np
from PIL import Image

from sherd.batching.gallery.page import gallery_page, write_gallery
from sherd.batching.gallery.thumbnail import thumbnail
from sherd.batching.ledger.place import PARTS, THUMBNAIL
from sherd.batching.ledger.rows import BatchRow


def rows(count: int) -> list[BatchRow]:
    return [
        BatchRow(f"p{k}", f"p{k}.ply", "whole.ply", "good", chance=0.5, folder=f"{PARTS}/p{k}")
        for k in range(count)
    ]


def test_a_thousand_parts_are_one_page_below_20_megabytes() -> None:
    picture = "data:image/webp;base64," + base64.b64encode(bytes(12_000)).decode()
    many = rows(1000)
    page = gallery_page("many", many, {row.name: picture for row in many})
    assert len(page) < 20e6
    assert "http" not in re.sub(r"http-equiv|http://www\.w3\.org\S*", "", page)


def test_names_and_reasons_cannot_leave_their_place(tmp_path) -> None:
    evil = '</script><script>alert("x")</script>{{title}}'
    page = gallery_page(evil, [BatchRow("a b#", "x", reason=evil, folder="parts/a b#")], {})
    assert "<script>alert" not in page
    content = re.search(r'id="rows">(.*?)</script>', page)
    (card,) = json.loads(content[1])
    assert card["reason"] == evil
    assert card["link"] == "parts/a%20b%23/report.html"


def test_pictures_are_inside_and_of_very_many_beside_the_page(tmp_path, monkeypatch) -> None:
    for row in rows(2):
        (tmp_path / row.folder).mkdir(parents=True)
        (tmp_path / row.folder / THUMBNAIL).write_bytes(b"RIFF")
    write_gallery(tmp_path, [*rows(2), BatchRow("lost", "lost.ply")])
    assert (tmp_path / "gallery.html").read_text().count("data:image/webp;base64,UklGRg==") == 2
    monkeypatch.setattr("sherd.batching.gallery.page.MOST_INSIDE", 1)
    write_gallery(tmp_path, rows(2))
    assert "parts/p1/thumbnail.webp" in (tmp_path / "gallery.html").read_text()


def test_even_noise_gives_a_small_thumbnail(tmp_path) -> None:
    noise = np.random.default_rng(0).integers(0, 256, (700, 1600, 3), dtype=np.uint8)
    Image.fromarray(noise).save(tmp_path / "match.png")
    assert 0 < len(thumbnail(tmp_path / "match.png")) <= 12_000
