# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

NAME = 'rocsafe_dispersion'

setup(
    name=NAME,
    version='0.2.0',
    description='Chemical and biological releases of ROCSAFE.',
    license='Apache-2.0',
    maintainer='ROCSAFE maintainers',
    maintainer_email='maintainers@rocsafe.invalid',
    packages=find_packages(),
    package_data={
        NAME: [
            'py.typed',
            'agents/*.json',
            'identification/*.json',
            'identification/procedures/*.md',
        ]
    },
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + NAME]),
        ('share/' + NAME, ['package.xml']),
    ],
    extras_require={'test': ['pytest'], 'dense': ['degadisx==0.1.4']},
    zip_safe=False,
    entry_points={
        'console_scripts': [
            'air = rocsafe_dispersion.air_node:main',
            'advisor = rocsafe_dispersion.advisor_node:main',
            'estimator = rocsafe_dispersion.estimator_node:main',
            'advise = rocsafe_dispersion.command_line.advise_command:main',
            'site-wind = rocsafe_dispersion.command_line.site_wind_command:main',
            'locate-release = rocsafe_dispersion.command_line.locate_command:main',
        ]
    },
)
