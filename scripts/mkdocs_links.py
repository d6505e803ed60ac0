"""mkdocs hook: rewrites links that lead out of docs/ into code text, and keeps pages for developers
out of the search.

Pages link to sources (`../../recon4d/model/exposure.h`), which a repository viewer follows. The
site does not hold the sources, so such a link becomes the path of the file in the repository.
"""
import json
import pathlib
import posixpath
import re

# [text](target), but not an image; the target has no blank and no closing bracket.
LINK = re.compile(r"(?<!!)\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(([^()\s]+)\)")
FENCE = re.compile(r"^\s*(```|~~~)")


def _path_out_of_docs(page_folder, target):
    """The path of `target` from the repository's root, or None where it stays in docs/."""
    if re.match(r"[a-z][a-z0-9+.-]*:|#|/", target, re.IGNORECASE):
        return None
    path = posixpath.normpath(posixpath.join("docs", page_folder, target.partition("#")[0]))
    return None if path == "docs" or path.startswith("docs/") else path


def _as_text(text, path):
    """The text of the link, with the path where the text does not name it."""
    plain = text.strip("`")
    if plain == path or path.endswith("/" + plain):
        return f"`{path}`"
    return f"{text} (`{path}`)"


def rewrite(markdown, page_folder):
    """The page's Markdown without links that lead out of docs/."""

    def replace(match):
        path = _path_out_of_docs(page_folder, match.group(2))
        return match.group(0) if path is None else _as_text(match.group(1), path)

    lines, fenced = [], False
    for line in markdown.split("\n"):
        if FENCE.match(line):
            fenced = not fenced
        lines.append(line if fenced else LINK.sub(replace, line))
    return "\n".join(lines)


def on_page_markdown(markdown, page, **_):
    return rewrite(markdown, posixpath.dirname(page.file.src_path))


def on_post_build(config, **_):
    path = pathlib.Path(config["site_dir"]) / "search/search_index.json"
    index = json.loads(path.read_text(encoding="utf-8"))
    index["docs"] = [doc for doc in index["docs"] if not doc["location"].startswith("development/")]
    path.write_text(json.dumps(index, ensure_ascii=False, separators=(",", ":")), encoding="utf-8")
