# SPDX-License-Identifier: Apache-2.0
"""Who may import whom, read from the source, so that the rules of CONTRIBUTING.md cannot rot."""

import ast
import configparser
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

SOURCES = Path(__file__).resolve().parents[1] / 'src'
STANDARD = sys.stdlib_module_names | {'__future__'}
MESSAGES = {
    'action_msgs',
    'builtin_interfaces',
    'diagnostic_msgs',
    'geometry_msgs',
    'nav_msgs',
    'rcl_interfaces',
    'rocsafe_interfaces',
    'rosgraph_msgs',
    'sensor_msgs',
    'std_msgs',
    'std_srvs',
    'unique_identifier_msgs',
    'tf2_msgs',
    'visualization_msgs',
}
# Import name of a library and its rosdep key, where they are not the same.
ROSDEP_KEYS = {
    'aiohttp': 'python3-aiohttp',
    'cryptography': 'python3-cryptography',
    'PIL': 'python3-pil',
    'cv2': 'python3-opencv',
    # The key that brings the pure reader and writer of MCAP along; it has none of its own.
    'jinja2': 'python3-jinja2',
    'markupsafe': 'python3-jinja2',  # which depends on it
    'mcap': 'mcap-ros2-support',
    'mcap_ros2': 'mcap-ros2-support',
    'msgpack': 'python3-msgpack',
    'numba': 'python3-numba',
    'numpy': 'python3-numpy',
    'piexif': 'python3-piexif',
    'pydantic': 'python3-pydantic',
    'pydantic_core': 'python3-pydantic',
    'pymavlink': 'python3-pymavlink-pip',
    'pyproj': 'python3-pyproj',
    'rasterio': 'python3-rasterio',
    'rich': 'python3-rich',
    'shapely': 'python3-shapely',
    'scipy': 'python3-scipy',
    'yaml': 'python3-yaml',
}
# Without a rosdep key: set-up brings it where it can; the flat camera and all other
# files of a map work without. Cordons and threat zones need contourpy, ranked procedures bm25s.
OPTIONAL = {
    'bm25s', 'contourpy', 'distributed', 'gymnasium', 'panda3d', 'pettingzoo', 'pmtiles',
    'pyarrow',
}  # fmt: skip
NUMERICAL = {'numpy', 'cv2', 'scipy', 'shapely', 'pyproj', 'rasterio', 'math', 'cmath', 'numba'}
DOMAINS = {
    'rocsafe_planner',
    'rocsafe_scene',
    'rocsafe_sim',
    'rocsafe_radiation',
    'rocsafe_dispersion',
    'rocsafe_ground',
    'rocsafe_mapping',
    'rocsafe_mavlink',
    'rocsafe_fleet',
}
# Packages that may import cores of others, and whose: a package, or a room or module of one.
# Everybody may import rocsafe_geo.
MAY_IMPORT = {
    'rocsafe_radiation': {'rocsafe_hazard'},
    'rocsafe_dispersion': {'rocsafe_hazard'},
    'rocsafe_scenario': {'rocsafe_planner.plan'},
    'rocsafe_sim': {'rocsafe_scene'},
    'rocsafe_learning': {'rocsafe_dispersion', 'rocsafe_radiation', 'rocsafe_scene'},
    'rocsafe_dataset': {'rocsafe_scene', 'rocsafe_sim', 'rocsafe_mapping'},
    # Compilation of loops; the order of more than twelve evidence points.
    'rocsafe_ground': {'rocsafe_planner.solver'},
    'rocsafe_console': {'rocsafe_view'},
    # A mission in one process: the cores of all parts, wired as the orchestrator wires nodes.
    'rocsafe_campaign': {
        'rocsafe_orchestrator.errors',
        'rocsafe_orchestrator.parameters',
        'rocsafe_orchestrator.planning_commands.plan_command',
        'rocsafe_orchestrator.processes.domain_lock',
        'rocsafe_orchestrator.process_table.executables',
        'rocsafe_orchestrator.provenance',
        'rocsafe_orchestrator.run_directory',
        'rocsafe_planner',
        'rocsafe_radiation',
        'rocsafe_scenario',
        'rocsafe_sim',
        'rocsafe_view',
    },
    # Agents plan by themselves; a simulated fleet flies by the planner's values.
    'rocsafe_fleet': {
        'rocsafe_planner.conversions',
        'rocsafe_planner.errors',
        'rocsafe_planner.export.plan_files',
        'rocsafe_planner.plan',
        'rocsafe_planner.planning',
        'rocsafe_planner.replanning',
        'rocsafe_planner.solver.precompile',
        # They choose where to measure with the estimator of the localizer.
        'rocsafe_radiation.errors',
        'rocsafe_radiation.localizer_options',
        'rocsafe_radiation.products.assessment',
        'rocsafe_radiation.readings',
    },
    'rocsafe_orchestrator': {
        # `rocsafe whatif` flies agents in simulated time.
        'rocsafe_fleet.trial',
        'rocsafe_scenario',
        'rocsafe_view',
        'rocsafe_planner.plan',
        # The `rocsafe` command plans, replans and checks in its own process.
        'rocsafe_planner.checked_planning',
        'rocsafe_planner.checking.plan_checker',
        # A run that is resumed has its plan in a file.
        'rocsafe_planner.conversions',
        'rocsafe_planner.errors',
        'rocsafe_planner.export.plan_files',
        'rocsafe_planner.replanning',
    },
}
# Packages that ROS and its messages are kept out of, nodes and conversions aside.
WITHOUT_ROS = DOMAINS | {
    'rocsafe_campaign',
    'rocsafe_geo',
    'rocsafe_hazard',
    'rocsafe_dataset',
    'rocsafe_learning',
    'rocsafe_scenario',
    'rocsafe_view',
    'rocsafe_console',
    'rocsafe_airsim',
}
EMPTY_NAMES = {'utils', 'util', 'helpers', 'helper', 'common', 'manager', 'misc', 'data'}
CLOCKS = {
    'time.time',
    'time.time_ns',
    'time.monotonic',
    'time.monotonic_ns',
    'time.perf_counter',
    'time.perf_counter_ns',
    'time.sleep',
    'datetime.now',
    'datetime.utcnow',
    'datetime.today',
    'date.today',
    'os.environ',
    'os.getenv',
}
# Modules beside a node's event loop, with the clock they may read and why.
EXEMPT_CLOCKS = {
    # a command: its first ROS domain; runs of whole processes get one each
    'rocsafe_campaign.campaign_command': {'os.environ'},
    # waits for other processes, with a limit
    'rocsafe_campaign.execution.cluster_workers': {'time.monotonic'},
    'rocsafe_campaign.execution.full_run': {'os.environ', 'time.monotonic', 'time.sleep'},
    'rocsafe_campaign.execution.journal': {'time.monotonic', 'time.sleep'},
    # which pipe and which graphics device to draw with is the machine's matter
    'rocsafe_scene.graphics.pipe': {'os.environ'},
    # tells the renderers of its workers how many threads each may use
    'rocsafe_dataset.worker_pool': {'os.environ'},
    # A command: tells the server which clock it goes by.
    'rocsafe_console.console_command': {'time.time', 'time.time_ns', 'os.environ'},
    # the time and the owner's folder of keys
    'rocsafe_console.seal_command': {'time.time', 'os.environ'},
    # A command that waits until vehicles are heard.
    'rocsafe_mavlink.preflight_command': {'time.monotonic', 'time.time', 'time.sleep'},
    'rocsafe_mavlink.signing_command': {'time.monotonic', 'time.time', 'time.sleep'},
    # a command: tells how long each stage took
    'rocsafe_mapping.command_line.map_command': {'time.perf_counter'},
    'rocsafe_planner.solver.search.outcome': {
        'time.monotonic'
    },  # default of an option: budget of time
}
# Of numpy.random, what makes a generator from a seed; all else draws from the global one.
SEEDED = {'default_rng', 'Generator', 'SeedSequence', 'BitGenerator', 'PCG64', 'Philox'}


# Rooms and modules without one, in the longest chain of imports within a package.
MOST_LEVELS = 10


@dataclass(frozen=True)
class Module:
    """One source file of a package, with what it imports."""

    path: Path

    @property
    def package(self) -> str:
        """Package that it belongs to."""
        return self.path.relative_to(SOURCES).parts[0]

    @property
    def name(self) -> str:
        """Dotted name."""
        return '.'.join(self.path.relative_to(SOURCES / self.package).with_suffix('').parts)

    @property
    def kind(self) -> str:
        """Its place in the rules: node, conversions or core."""
        if self.path.stem.endswith('_node'):
            return 'node'
        return 'conversions' if self.path.stem.endswith('conversions') else 'core'

    @cached_property
    def tree(self) -> ast.Module:
        """Syntax tree."""
        return ast.parse(self.path.read_text(), filename=str(self.path))

    @cached_property
    def nodes(self) -> list[ast.AST]:
        """All nodes of the syntax tree."""
        return list(ast.walk(self.tree))

    @cached_property
    def imports(self) -> set[str]:
        """Dotted names of the modules it imports, wherever in the file."""
        found = set()
        for node in self.nodes:
            if isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0:
                found.add(str(node.module))
                found |= {f'{node.module}.{alias.name}' for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                raise AssertionError(f'{self.name} line {node.lineno}: relative import')
        return found

    @cached_property
    def loads(self) -> set[str]:
        """Dotted names of what it imports when it is imported itself, not for types alone."""
        found = set()
        waiting: list[ast.AST] = [self.tree]
        while waiting:
            node = waiting.pop()
            if isinstance(node, ast.Import):
                found |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                found |= {f'{node.module}.{alias.name}' for alias in node.names}
                found.add(str(node.module))
            is_later = isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
            is_for_types = isinstance(node, ast.If) and 'TYPE_CHECKING' in ast.unparse(node.test)
            if not is_later and not is_for_types:
                waiting += ast.iter_child_nodes(node)
        return found

    @property
    def roots(self) -> set[str]:
        """First parts of the imported names."""
        return {name.split('.')[0] for name in self.imports}

    @cached_property
    def texts(self) -> set[str]:
        """Its literal texts, such as names of packages whose executables it starts."""
        constants = (node.value for node in self.nodes if isinstance(node, ast.Constant))
        return {value for value in constants if isinstance(value, str)}

    @cached_property
    def accesses(self) -> set[str]:
        """Dotted names that it reads, such as ``time.time``."""
        return {
            ast.unparse(node)
            for node in self.nodes
            if isinstance(node, ast.Attribute) and _is_dotted(node)
        }


def _is_dotted(node: ast.expr) -> bool:
    while isinstance(node, ast.Attribute):
        node = node.value
    return isinstance(node, ast.Name)


MODULES = [Module(path) for path in sorted(SOURCES.glob('*/rocsafe_*/**/*.py'))]
NODES = [module for module in MODULES if module.kind == 'node']
CONVERSIONS = [module for module in MODULES if module.kind == 'conversions']
CORES = [module for module in MODULES if module.kind == 'core' and module.package in WITHOUT_ROS]
MANIFESTS = sorted(SOURCES.glob('*/package.xml'))
OURS = {path.parent.name for path in MANIFESTS}


def offenders(
    modules: list[Module], forbidden: Callable[[Module], set[str]]
) -> dict[str, set[str]]:
    """Return the modules that have something forbidden, with what they have."""
    return {module.name: found for module in modules if (found := forbidden(module))}


def test_every_kind_of_module_is_found():
    """The rules below look at something."""
    assert NODES
    assert CONVERSIONS
    assert {module.package for module in CORES} == WITHOUT_ROS
    assert set(MAY_IMPORT) <= OURS


def test_geo_stands_on_numbers_alone():
    """rocsafe_geo imports numerical libraries and what reads rasters and YAML, nothing of ROS."""
    allowed = STANDARD | {'rocsafe_geo', 'numpy', 'pyproj', 'shapely', 'rasterio', 'yaml'}
    modules = [module for module in MODULES if module.package == 'rocsafe_geo']
    assert not offenders(modules, lambda module: module.roots - allowed)


@pytest.mark.slow
def test_core_knows_neither_ros_nor_messages():
    """Cores can be used and tested on a machine without ROS."""

    def forbidden(module: Module) -> set[str]:
        own = {name for name in module.imports if name.startswith(f'{module.package}.')}
        outer = {name for name in own if name.split('.')[1].endswith(('_node', 'conversions'))}
        return module.roots & (MESSAGES | {'rclpy', 'rocsafe_ros'}) | outer

    assert not offenders(CORES, forbidden)


def test_core_reads_no_clock_and_no_global_generator():
    """Time and generators come in as arguments, so every run can be replayed from its seed."""

    def forbidden(module: Module) -> set[str]:
        clocks = module.accesses & CLOCKS - EXEMPT_CLOCKS.get(module.name, set())
        drawn = {name.rsplit('.', 1)[1] for name in module.accesses if '.random.' in name}
        drawn |= {name.rsplit('.', 1)[1] for name in module.imports if 'numpy.random.' in name}
        return clocks | (module.roots & {'random'}) | (drawn - SEEDED)

    assert not offenders(CORES, forbidden)
    names = {module.name for module in MODULES}
    assert set(EXEMPT_CLOCKS) <= names, 'an exemption for a module that is gone'


def test_conversions_know_no_rclpy():
    """Messages are values: converting them needs no node."""

    def forbidden(module: Module) -> set[str]:
        allowed = {module.package, 'rocsafe_geo', 'rocsafe_ros', 'numpy'} | MESSAGES | STANDARD
        allowed |= {name.split('.')[0] for name in MAY_IMPORT.get(module.package, set())}
        of_ros = {name for name in module.imports if name.startswith('rocsafe_ros.')}
        if module.package == 'rocsafe_ros':
            of_ros = set()
        wrong = {name for name in of_ros if not name.startswith('rocsafe_ros.conversions')}
        return (module.roots - allowed) | wrong

    assert not offenders(CONVERSIONS, forbidden)


def test_node_does_no_arithmetic():
    """A node converts, calls and publishes; numbers belong to the core."""

    def forbidden(module: Module) -> set[str]:
        ours = {module.package, 'rocsafe_ros', 'rocsafe_geo', 'rclpy'}
        ours |= {name.split('.')[0] for name in MAY_IMPORT.get(module.package, set())}
        return (module.roots - (ours | MESSAGES | STANDARD)) | (module.roots & NUMERICAL)

    assert not offenders(NODES, forbidden)


def test_packages_import_only_whom_they_may():
    """Domain packages meet in messages, and in files; the exceptions stand in MAY_IMPORT."""
    shared = {'rocsafe_geo', 'rocsafe_ros', 'rocsafe_interfaces', 'tf2_msgs'}

    def forbidden(module: Module) -> set[str]:
        allowed = {module.package} | shared | MAY_IMPORT.get(module.package, set())
        ours = {name for name in module.imports if name.split('.')[0] in OURS}
        return {name for name in ours if not _is_within(name, allowed)}

    assert not offenders(MODULES, forbidden)


def test_the_values_of_a_plan_need_nothing_else():
    """Whoever imports them gets no other room of the planner."""
    modules = [module for module in MODULES if module.name.startswith('rocsafe_planner.plan.')]
    allowed = {'rocsafe_planner.plan', 'rocsafe_geo'}

    def forbidden(module: Module) -> set[str]:
        ours = {name for name in module.imports if name.split('.')[0] in OURS}
        return {name for name in ours if not _is_within(name, allowed)}

    assert modules
    assert not offenders(modules, forbidden)


def _is_within(name: str, allowed: set[str]) -> bool:
    """Return whether a dotted name is one of the names allowed, or below one."""
    return any(name == other or name.startswith(f'{other}.') for other in allowed)


def test_no_circle_of_rooms():
    """Folders of a package never import each other in a circle, nor do the packages."""
    rooms: dict[str, set[str]] = {}
    names = {module.name for module in MODULES}
    for module in MODULES:
        room = module.name.rpartition('.')[0]
        for name in module.imports & names:
            if (other := name.rpartition('.')[0]) != room and {room, other}.isdisjoint(OURS):
                rooms.setdefault(room, set()).add(other)
    TopologicalSorter(rooms).prepare()


def test_no_circle_of_modules():
    """Also none of imports for types alone, or within functions."""
    names = {module.name for module in MODULES}
    TopologicalSorter({m.name: m.imports & (names - {m.name}) for m in MODULES}).prepare()


def levels(package: str) -> list[str]:
    """Return the longest chain of imports between the rooms and single modules of a package."""
    own = {m.name: m for m in MODULES if m.package == package}
    doors: dict[str, set[str]] = {}
    for name, module in own.items():
        door = _door(name)
        doors.setdefault(door, set()).update(_door(other) for other in module.loads & own.keys())
    for door, others in doors.items():
        others.discard(door)
    chains: dict[str, list[str]] = {}
    for door in TopologicalSorter(doors).static_order():
        below = max((chains[other] for other in doors[door]), key=len, default=[])
        chains[door] = [door, *below]
    return max(chains.values(), key=len)


def _door(name: str) -> str:
    """Return what one sees in the folder of a package: a room, or a module without one."""
    return '.'.join(name.split('.')[:2])


def test_no_chain_of_imports_is_long():
    """Who follows a call down through a package passes few rooms."""
    packages = {module.package for module in MODULES}
    assert {n: chain for n in packages if len(chain := levels(n)) > MOST_LEVELS} == {}


def test_module_has_a_name_that_says_something():
    """No drawer names; ruff asks for licence and docstring."""

    def forbidden(module: Module) -> set[str]:
        return set(module.path.relative_to(SOURCES).with_suffix('').parts) & EMPTY_NAMES

    assert not offenders(MODULES, forbidden)
    unlicensed = [
        module.name
        for module in MODULES
        if not module.path.read_text().startswith('# SPDX-License-Identifier: Apache-2.0\n')
    ]
    assert not unlicensed


TO_RUN = ('depend', 'exec_depend')
TO_BUILD_OR_TEST = ('buildtool_depend', 'build_depend', 'test_depend')


def declared(manifest: Path, *kinds: str) -> set[str]:
    """Return the keys of the dependencies of a package, of some kinds."""
    root = ElementTree.parse(manifest).getroot()  # noqa: S314 - our own files
    return {str(item.text).strip() for kind in kinds for item in root.findall(kind)}


def test_package_declares_what_it_imports():
    """And what it starts, by rosdep keys in package.xml, and nothing else."""
    faults = {}
    for manifest in MANIFESTS:
        name = manifest.parent.name
        modules = [module for module in MODULES if module.package == name]
        imported = {root for module in modules for root in module.roots} - STANDARD
        wanted = {ROSDEP_KEYS.get(root, root) for root in imported - {name} - OPTIONAL}
        started = {text for module in modules for text in module.texts}
        missing = wanted - declared(manifest, *TO_RUN)
        needless = declared(manifest, *TO_RUN) - wanted - started if modules else set()
        if missing or needless:
            faults[name] = {'missing': missing, 'needless': needless}
    assert not faults


def test_dependencies_are_names_that_rosdep_knows():
    """``rosdep install`` on a sourced Jazzy resolves every dependency."""
    lines = Path(__file__).with_name('rosdep_names.txt').read_text().splitlines()
    known = {line for line in lines if line and not line.startswith('#')}
    used = {key for path in MANIFESTS for key in declared(path, *TO_RUN, *TO_BUILD_OR_TEST)}
    assert used - OURS - known == set()


def test_colcon_runs_the_same_tests():
    """``colcon test`` finds the tests of a package where ``make test`` does."""
    for path in SOURCES.glob('*/setup.cfg'):
        config = configparser.ConfigParser()
        config.read(path)
        options = config['tool:pytest']
        assert list((path.parent / options['testpaths']).glob('test_*.py')), path
        assert options['addopts'] == '--import-mode=importlib --rootdir=../..', path
