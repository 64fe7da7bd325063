# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

NAME = 'rocsafe_mapping'

setup(
    name=NAME,
    version='0.2.0',
    description='Image store and mosaic of ROCSAFE.',
    license='Apache-2.0',
    maintainer='ROCSAFE maintainers',
    maintainer_email='maintainers@rocsafe.invalid',
    packages=find_packages(),
    package_data={NAME: ['py.typed']},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + NAME]),
        ('share/' + NAME, ['package.xml']),
    ],
    extras_require={'test': ['pytest']},
    zip_safe=False,
    entry_points={
        'console_scripts': [
            'changes = rocsafe_mapping.command_line.changes_command:main',
            'collector = rocsafe_mapping.collector_node:main',
            'import = rocsafe_mapping.command_line.import_command:main',
            'map = rocsafe_mapping.command_line.map_command:main',
            'mosaic = rocsafe_mapping.mosaic_node:main',
            'repository = rocsafe_mapping.command_line.repository_command:main',
        ],
    },
)
