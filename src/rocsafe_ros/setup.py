# SPDX-License-Identifier: Apache-2.0
from setuptools import find_packages, setup

NAME = 'rocsafe_ros'

setup(
    name=NAME,
    version='0.2.0',
    description='Parts that all ROCSAFE nodes share: parameters, topics, conversions, life cycle.',
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
)
