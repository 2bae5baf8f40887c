"""
Requirements of ROS 2 from Python wheels, for pip on a machine without ROS.

ROS_DISTRO selects the distribution; without it the wheels are those of Jazzy. Read by setup.py,
and by scikit-build-core as provider of dynamic metadata (see pyproject.toml).
"""

import os

VERSIONS = {
    'jazzy': {
        'rclpy': '7.1.6',
        'common-interfaces': '5.3.6',
        'rmw-fastrtps-cpp': '8.4.3',
        'ament-package': '0.16.4',
        'ament-flake8': '0.17.3',
        'ament-pep257': '0.17.3',
        'ament-cmake': '2.5.4',
        'ament-cmake-include-directories': '2.5.4',
        'ament-cmake-gmock': '2.5.4',
        'ament-cmake-gtest': '2.5.4',
        'ament-cmake-pytest': '2.5.4',
        'ament-cmake-ros': '0.12.0',
        'python-cmake-module': '0.11.1',
        'rosidl-core-generators': '0.2.0',
        'rosidl-default-generators': '1.6.0',
    },
    'kilted': {
        'rclpy': '9.1.2',
        'common-interfaces': '5.5.1',
        'rmw-fastrtps-cpp': '9.3.3',
        'ament-package': '0.17.2',
        'ament-flake8': '0.19.2',
        'ament-pep257': '0.19.2',
        'ament-cmake': '2.7.3',
        'ament-cmake-include-directories': '2.7.3',
        'ament-cmake-gmock': '2.7.3',
        'ament-cmake-gtest': '2.7.3',
        'ament-cmake-pytest': '2.7.3',
        'ament-cmake-ros-core': '0.14.5',
        'rosidl-core-generators': '0.3.1',
        'rosidl-default-generators': '1.7.1',
    },
}
RUN = ('rclpy', 'common-interfaces', 'rmw-fastrtps-cpp')
LINT = ('ament-package', 'ament-flake8', 'ament-pep257')
DISTRIBUTION = os.environ.get('ROS_DISTRO')
DISTRIBUTION = DISTRIBUTION if DISTRIBUTION in VERSIONS else 'jazzy'


def requirements(*names):
    """Return the pinned requirements of packages."""
    return [f'ros-{DISTRIBUTION}-{name}=={VERSIONS[DISTRIBUTION][name]}' for name in names]


def dynamic_metadata(field, settings):
    """Return the dependencies of the interfaces."""
    return ['numpy', *requirements(*RUN)]


def get_requires_for_dynamic_metadata(settings):
    """Return the ROS packages that building the interfaces needs."""
    return requirements(*sorted(VERSIONS[DISTRIBUTION].keys() - set(LINT[1:])))
