"""A report's page, parsed."""

from html.parser import HTMLParser
import re

HOSTILE = '=<script>alert("x")</script> & \'../a b\'\udcff'  # a name from outside


class Page(HTMLParser):
    """Elements, addresses, tables, and text with single spaces of a page."""

    def __init__(self, path):
        super().__init__()
        self.html = path.read_text(encoding='utf-8')
        self.elements, self._tables, self.text, self._cell = [], [], '', None
        self.feed(self.html)
        self.text = ' '.join(self.text.split())
        self.addresses = [attributes[name] for _, attributes in self.elements
                          for name in ('src', 'href') if name in attributes]

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        if tag in ('caption', 'tr'):
            self._tables += [[]] if tag == 'caption' else []
            self._tables[-1].append([])
        if tag in ('caption', 'td', 'th'):
            self._cell = ''

    def handle_endtag(self, tag):
        if tag in ('caption', 'td', 'th'):
            self._tables[-1][-1].append(' '.join(self._cell.split()))
            self._cell = None

    def handle_data(self, data):
        if self.elements and self.elements[-1][0] not in ('style', 'script'):
            self.text += data
        if self._cell is not None:
            self._cell += data

    def table(self, caption):
        """Return name of the row -> other cells, of the first table with such a caption."""
        _, *rows = next(table for table in self._tables if table[0][0].startswith(caption))
        return {row[0]: row[1:] for row in rows}

    def check_self_contained(self):
        """Check that the page fetches nothing, and that its addresses and ids are right."""
        ids = [attributes['id'] for _, attributes in self.elements if 'id' in attributes]
        assert len(set(ids)) == len(ids)
        for address in self.addresses:
            assert address.startswith('data:image/svg+xml;base64,') or address[1:] in ids
        assert not re.search(r'url\(|@import|https?:', self.html)
        assert [tag for tag, _ in self.elements].count('script') == 1
        assert len(self.html) < 3e6
