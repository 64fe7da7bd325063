# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

NAME = 'rocsafe_console'

setup(
    name=NAME,
    version='0.2.0',
    description='Web page of the operator of ROCSAFE: live map, orders, users, evidence log.',
    license='Apache-2.0',
    maintainer='ROCSAFE maintainers',
    maintainer_email='maintainers@rocsafe.invalid',
    packages=find_packages(),
    package_data={
        NAME: ['py.typed', 'static/*', 'static/vendor/*', 'static/vendor/leaflet/*'],
    },
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + NAME]),
        ('share/' + NAME, ['package.xml']),
    ],
    extras_require={'test': ['pytest']},
    zip_safe=False,
    entry_points={
        'console_scripts': [
            'console = rocsafe_console.serve_node:main',
            'users = rocsafe_console.users_command:main',
            'seal = rocsafe_console.seal_command:main',
            'verify = rocsafe_console.verify_command:main',
        ],
    },
)
