# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

NAME = 'rocsafe_scene'

setup(
    name=NAME,
    version='0.2.0',
    description='Scenes of ROCSAFE, the engine that renders them, and camera optics.',
    license='Apache-2.0',
    maintainer='ROCSAFE maintainers',
    maintainer_email='maintainers@rocsafe.invalid',
    packages=find_packages(),
    package_data={NAME: ['py.typed', 'engine/*.glsl', 'flat_ground/photographs/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + NAME]),
        ('share/' + NAME, ['package.xml']),
    ],
    extras_require={'test': ['pytest']},
    zip_safe=False,
    entry_points={
        'console_scripts': [
            'scene = rocsafe_scene.command_line.scene_command:main',
        ],
    },
)
