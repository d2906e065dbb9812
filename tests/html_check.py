"""Reading pages in tests: tags close in order, ids are unique, and what stands where."""

from __future__ import annotations

from html.parser import HTMLParser


class Checker(HTMLParser):
    """Tags must close in order; ids must be unique. text: what is read, scripts apart; scripts: their text;
    tags: (name, names of its attributes) in order, those within figures apart; metas: the head's."""

    VOID = ("meta", "br", "hr", "img", "input", "link")

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.text: list[str] = []
        self.scripts: list[str] = []
        self.tags: list[tuple[str, tuple[str, ...]]] = []
        self.links: list[str] = []
        self.metas: list[dict[str, str | None]] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.ids += [value for name, value in attrs if name == "id" and value]
        self.links += [value for name, value in attrs if name in ("src", "href") and value]
        if "svg" not in self.open:
            self.tags.append((tag, tuple(name for name, _ in attrs)))
        if tag == "meta":
            self.metas.append(dict(attrs))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        (self.scripts if self.open[-1:] == ["script"] else self.text).append(data)

    @property
    def policy(self) -> dict[str, list[str]]:
        """The page's Content-Security-Policy, by directive; the first tags of the head say it."""
        assert [tag for tag, _ in self.tags[:4]] == ["html", "head", "meta", "meta"]
        said = [meta["content"] or "" for meta in self.metas if meta.get("http-equiv")]
        assert len(said) == 1
        return {name: allowed for name, *allowed in (part.split() for part in said[0].split(";"))}


def parse(html: str) -> Checker:
    checker = Checker()
    checker.feed(html)
    checker.close()
    assert checker.open == []
    assert len(checker.ids) == len(set(checker.ids))
    return checker
