# SPDX-License-Identifier: Apache-2.0
"""Hook of mkdocs: adds the pages made from code, and the files outside docs/ that pages link to.

A link that leaves docs/ is good on a code host. Here it goes to the page that holds the content
of that file, or to a copy of the file.
"""

import posixpath
import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / 'tools')]

from mkdocs.exceptions import PluginError  # noqa: E402
from mkdocs.structure.files import File, Files, InclusionLevel  # noqa: E402

from documentation.python_pages import python_pages  # noqa: E402
from documentation.scenario_keys import scenario_page  # noqa: E402

# Documents at the top of the repository, and their pages.
DOCUMENTS = {
    'README.md': 'index.md',
    'CHANGELOG.md': 'changelog.md',
    'CONTRIBUTING.md': 'contributing.md',
    'LICENSE': 'LICENSE.txt',
    'SECURITY.md': 'security.md',
    'QUALITY_DECLARATION.md': 'quality.md',
}
_CELL = re.compile(r'<td.*?</td>', re.S)
_LONG_NAME = re.compile(r'<code>([^<]{25,})</code>')
_LINK = re.compile(r'(?<=\]\()(?!https?:|mailto:|#)([^)#\s]+)')


def on_files(files: Files, config: Any) -> Files:
    """Add the pages made from code and from documents outside docs/, and what they link to."""
    pages = {'reference/scenario.md': scenario_page(), **python_pages()}
    for name, page in DOCUMENTS.items():
        if (ROOT / name).exists():
            pages[page] = (ROOT / name).read_text()
    for uri, content in pages.items():
        files.append(File.generated(config, uri, content=content))
    linked = {
        target
        for file in files.documentation_pages()
        for target in _LINK.findall(file.content_string)
        for target in [_target(file.src_uri, target)]
        if not target.startswith('docs/') and target not in DOCUMENTS
    }
    for target in sorted(linked):
        if (ROOT / target).is_file():
            copy = File.generated(config, target, abs_src_path=str(ROOT / target))
            # Files and folders whose name begins with a dot would be left out.
            copy.inclusion = InclusionLevel.INCLUDED
            files.append(copy)
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Return the text of a page with links of the repository changed to links of the site."""
    uri = page.file.src_uri
    return _LINK.sub(lambda match: _site_link(uri, match.group(1)), markdown)


def on_page_content(html: str, **_: Any) -> str:
    """Return a page whose long names in tables may break: after a slash, dot or underscore."""
    return _CELL.sub(lambda cell: _LONG_NAME.sub(_breakable, cell.group()), html)


def _breakable(name: re.Match[str]) -> str:
    parts = re.sub(r'(?<=[/._])(?=\w)', '<wbr>', name.group(1))
    return f'<code class="long">{parts}</code>'


def _site_link(uri: str, link: str) -> str:
    target = _target(uri, link)
    if target in DOCUMENTS:
        inside = DOCUMENTS[target]
    elif target.startswith('docs/'):
        inside = target.removeprefix('docs/')
    elif (ROOT / target).is_file() or _is_page(uri):
        inside = target
    else:
        raise PluginError(f'{uri}: {link} is no file of this repository')
    return posixpath.relpath(inside, posixpath.dirname(uri) or '.')


def _target(uri: str, link: str) -> str:
    """Return the path in the repository that a link of a page leads to."""
    document = next((name for name, page in DOCUMENTS.items() if page == uri), f'docs/{uri}')
    return posixpath.normpath(posixpath.join(posixpath.dirname(document), link))


def _is_page(uri: str) -> bool:
    """Whether a page was made from code: its links are those of the site already."""
    return uri.startswith('reference/')
