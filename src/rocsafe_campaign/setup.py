# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

NAME = 'rocsafe_campaign'

setup(
    name=NAME,
    version='0.2.0',
    description='Campaigns of ROCSAFE: many simulated missions and what moves their result.',
    license='Apache-2.0',
    maintainer='ROCSAFE maintainers',
    maintainer_email='maintainers@rocsafe.invalid',
    packages=find_packages(),
    package_data={NAME: ['py.typed', 'results/templates/*.html']},
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/' + NAME]),
        ('share/' + NAME, ['package.xml']),
    ],
    extras_require={'test': ['pytest'], 'cluster': ['distributed'], 'parquet': ['pyarrow']},
    zip_safe=False,
    entry_points={
        'console_scripts': ['campaign = rocsafe_campaign.campaign_command:main'],
    },
)
