"""The check of the built site finds what it is there for."""

import pytest
from check_links import broken_links, main


def site(folder, **pages):
    """Write pages by name and return their folder."""
    for name, body in pages.items():
        path = folder / f"{name}.html"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"<html><body>{body}</body></html>")
    return folder


def test_a_whole_site_passes(tmp_path, capsys):
    (tmp_path / "picture.png").write_bytes(b"")
    body = '<h1 id="top"><a href="other.html#part">there</a> <a href="#top">up</a> <img src="picture.png?v=1"></h1>'
    folder = site(tmp_path, index=body, other='<h2 id="part"></h2> <a href="https://example.org/nowhere">out</a>')
    assert broken_links(folder) == []
    main(folder)
    assert str(folder / "index.html") in capsys.readouterr().out


@pytest.mark.parametrize(
    ("link", "complaint"),
    [
        ('<a href="gone.html">x</a>', "index.html: gone.html leads to no file"),
        ('<img src="gone.png">', "index.html: gone.png leads to no file"),
        ('<img srcset="gone.png 2x">', "index.html: gone.png leads to no file"),
        ('<a href="other.html#gone">x</a>', "index.html: other.html#gone leads to no anchor"),
        ('<a href="#gone">x</a>', "index.html: #gone leads to no anchor"),
        ('<a href="../outside.html">x</a>', "index.html: ../outside.html leads out of the site"),
    ],
)
def test_a_planted_fault_is_found(tmp_path, link, complaint):
    folder = site(tmp_path, index=link, other='<p id="part"></p>')
    assert broken_links(folder) == [complaint]
    with pytest.raises(SystemExit, match="1 broken links"):
        main(folder)


def test_names_that_need_quoting_and_folders_are_followed(tmp_path):
    folder = site(tmp_path, index='<a href="sub/a%20b.html#%C3%A9">x</a> <a href="sub/">y</a>')
    site(folder / "sub", **{"a b": '<p id="é"></p>', "index": ""})
    assert broken_links(folder) == []


def test_no_site_is_no_whole_site(tmp_path):
    with pytest.raises(ValueError, match="site must hold HTML files"):
        broken_links(tmp_path)
