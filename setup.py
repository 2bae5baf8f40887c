"""Package baxter_dynamics_ros: the model needs only NumPy; the extras add nodes and tools."""

from glob import glob
from importlib.util import find_spec
import os
from pathlib import Path
from runpy import run_path
import sys

from setuptools import Extension, find_packages, setup
from setuptools.command.build_ext import build_ext

package_name = 'baxter_dynamics_ros'

# resolve(): colcon build --symlink-install runs a link to this file in the build folder.
folder = Path(__file__).resolve().parent
wheels = run_path(str(folder / 'baxter_dynamics_interfaces' / 'ros_wheels.py'))
# On a ROS 2 machine these come from package.xml instead. Wheels: Linux x86-64 only.
ros = [*wheels['requirements'](*wheels['RUN']), 'pin==4.1.0']
# Commands evaluate and calibrate, without ROS.
offline = [
    'pin==4.1.0',
    'rosbags==0.11.9',
    'mcap==1.6.0',
    'zstandard>=0.22',
    'scipy>=1.11',
    'pyyaml>=6.0',
    'matplotlib==3.10.9',
    'jinja2>=3.1',
    'rich>=13.3.3',
    # calibrate --plan tries the motion on the fake Baxter.
    'mujoco==3.17.0',
    'hpp-baxter==9.0.2',  # the manufacturer's robot description
]
# Parameter files, and the manufacturer's robot description for `export urdf`.
export = ['pyyaml>=6.0', 'hpp-baxter==9.0.2']
# Command panel; the last two are the manufacturer's description with meshes, and their format.
panel = ros + [
    'viser==1.1.1',
    'yourdfpy==0.0.60',
    'example-robot-data==6.0.0',
    'pycollada==0.9.3',
]
# Compared by benchmarks/model.py.
benchmark = ['pin==4.1.0', 'mujoco==3.17.0']
demo = ros + offline
doc = ['sphinx>=8', 'myst-parser>=4']
test = demo + export + panel + doc + [
    'casadi==3.8.2',  # generates the closed form, and runs the exported Python file
    'sympy==1.14.0',
    'pybind11>=2.11',  # colcon builds the extension without pyproject.toml
    'hypothesis==6.170.15; python_version >= "3.11"',
    'hypothesis; python_version < "3.11"',
    'mypy==2.4.1',
    'pytest==9.0.3',
    'pytest-timeout==2.4.0',
    'pytest-xdist==3.8.0',
    'playwright==1.65.2',  # drives the Chromium of the system
    'colcon-common-extensions==0.3.0',
    *wheels['requirements'](*wheels['LINT']),
    'flake8==7.1.2',
    'flake8-blind-except==0.2.1',
    'flake8-builtins==2.5.0',
    'flake8-class-newline==1.6.0',
    'flake8-comprehensions==3.16.0',
    'flake8-deprecated==2.2.1',
    'flake8-docstrings==1.7.0',
    'flake8-import-order==0.19.2',
    'flake8-quotes==3.4.0',
    'pydocstyle==6.3.0',
    # 71 makes wheels; ament_python's setup.py calls and flake8-import-order need one before 80.
    'setuptools>=71,<80',
    'catkin_pkg',
]


class OptionalBuild(build_ext):
    """Builds the extension if possible; without it the model uses its Python engine."""

    def build_extensions(self):
        """Build each extension, or omit it and print the reason."""
        for extension in list(self.extensions):
            try:
                self.build_extension(extension)
            except Exception as error:  # compiler, linker or platform
                self.extensions.remove(extension)
                print(f'{package_name}: the compiled engine was not built ({error}); using '
                      'the Python engine', file=sys.stderr)


def pybind11_folders():
    """Return the include folders of pybind11, unless only the system package is installed."""
    try:
        import pybind11
    except ImportError:
        return []
    return [pybind11.get_include()]


setup(
    name=package_name,
    version='0.1.0',
    packages=find_packages(include=[package_name, package_name + '.*']),
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + package_name]),
        ('share/' + package_name, ['package.xml']),
        ('share/' + package_name + '/config', glob('config/*')),
        ('share/' + package_name + '/launch', glob('launch/*.launch.xml')),
    ],
    python_requires='>=3.10',
    install_requires=['numpy>=1.24'],
    extras_require={'ros': ros, 'offline': offline, 'demo': demo, 'export': export, 'panel': panel,
                    'benchmark': benchmark, 'doc': doc, 'test': test},
    package_data={package_name: ['py.typed', 'report/*.j2', 'export/*.c', 'export/*.tex',
                                 'model/_closed_form.[ch]']},
    ext_modules=[Extension(
        f'{package_name}.model._compiled', [f'{package_name}/model/_compiled.cpp'],
        depends=[f'{package_name}/model/_closed_form.{ending}' for ending in 'ch'],
        include_dirs=pybind11_folders(),
        extra_compile_args=['-std=c++17', '-g0', '-fvisibility=hidden',
                            *([] if '-O' in os.environ.get('CFLAGS', '') else ['-O3'])])],
    cmdclass={'build_ext': OptionalBuild},
    zip_safe=False,
    maintainer='baxter_dynamics_ros maintainers',
    maintainer_email='maintainers@baxter-dynamics.example',
    description='Lagrange-Euler dynamics of the Baxter robot: model, ROS 2 node, calibration.',
    long_description=(folder / 'README.md').read_text(encoding='utf-8'),
    long_description_content_type='text/markdown',
    license='Apache-2.0',
    entry_points={
        'console_scripts': [
            'baxter_dynamics = baxter_dynamics_ros.cli.main:main',
            'fake_baxter = baxter_dynamics_ros.cli.main:fake_baxter',
            'joint_state_bridge = baxter_dynamics_ros.cli.main:joint_state_bridge',
            'torque_predictor = baxter_dynamics_ros.cli.main:torque_predictor',
        ],
    },
)

# colcon runs one of these commands, pip neither. The folder beside this file is no installed
# package: it has no __init__.py and so no origin.
interfaces = find_spec('baxter_dynamics_interfaces')
if {'install', 'develop'} & set(sys.argv) and not (interfaces and interfaces.origin):
    print(f'{package_name}: baxter_dynamics_interfaces is neither built nor sourced: the node '
          'will have no services. colcon does not look below a package; build both with\n'
          f'  colcon build --base-paths {folder} {folder}/baxter_dynamics_interfaces',
          file=sys.stderr)
