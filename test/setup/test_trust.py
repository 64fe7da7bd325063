# SPDX-License-Identifier: Apache-2.0
"""Files that a stranger looks for say what is true."""

import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]


def test_one_version_everywhere():
    """Of all our packages, the citation and the README."""
    manifests = (ROOT / 'src').glob('rocsafe_*/package.xml')
    versions = {ElementTree.parse(path).getroot().findtext('version') for path in manifests}  # noqa: S314
    for path in (ROOT / 'src').glob('rocsafe_*/setup.py'):
        versions |= set(re.findall(r"version='([^']+)'", path.read_text()))
    versions.add(yaml.safe_load((ROOT / 'CITATION.cff').read_text())['version'])
    versions |= set(re.findall(r'^Version ([\d.]+\d)', (ROOT / 'README.md').read_text(), re.M))
    assert len(versions) == 1


def test_the_workflow_runs_what_a_developer_runs():
    """And every target that it and the hooks before a commit name is there."""
    workflow = yaml.safe_load((ROOT / '.github/workflows/ci.yml').read_text())
    steps = workflow['jobs']['checks-and-tests']['steps']
    commands = [step['run'] for step in steps if 'run' in step]
    assert '.ci/run' in commands
    targets = set(re.findall(r'^([a-z-]+):', (ROOT / 'Makefile').read_text(), re.M))
    assert {word.split()[1] for word in commands if word.startswith('make ')} <= targets
    hooks = yaml.safe_load((ROOT / '.pre-commit-config.yaml').read_text())['repos'][0]['hooks']
    assert {'ruff', 'typos'} <= {Path(hook['entry'].split()[0]).name for hook in hooks}


def test_every_source_file_names_its_licence():
    """Of ours; what is of others has a notice at its head."""
    kinds = ('*.py', '*.js', '*.mjs', '*.css', '*.sh', '*.cpp', '*.glsl', 'Makefile', 'Dockerfile')
    git = shutil.which('git')
    if git is None or not (ROOT / '.git').exists():
        pytest.skip('no checkout of git')
    listed = subprocess.run(
        [git, 'ls-files', '-z', *kinds], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.split('\0')[:-1]
    heads = {name: (ROOT / name).read_text(encoding='utf-8')[:400] for name in listed}
    assert len(heads) > 1000
    without = [name for name, head in heads.items() if 'SPDX-License-Identifier' not in head]
    others = [name for name in without if 'vendor/' in name or 'Copyright' in heads[name]]
    assert sorted(without) == sorted(others)
    assert len(others) <= 3


@pytest.mark.parametrize('name', ['SECURITY.md', 'QUALITY_DECLARATION.md'])
def test_a_reader_is_warned_that_no_hardware_has_flown(name):
    """Also one who did not read the README; and links lead somewhere."""
    text = (ROOT / name).read_text()
    assert 'No hardware has been flown' in text.replace('\n', ' ')
    links = re.findall(r'\]\((?!https?:|#)([^)#]+)', text)
    assert [link for link in links if not (ROOT / link).exists()] == []


def test_readmes_of_packages_are_current():
    """``python tools/package_readmes.py`` would change nothing."""
    pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')
    import package_readmes

    for path, text in package_readmes.readmes().items():
        assert path.read_text() == text, path
