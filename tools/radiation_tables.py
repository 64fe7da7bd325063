# SPDX-License-Identifier: Apache-2.0
"""Make the tables of photon and nuclide data in ``rocsafe_radiation/tables``.

Run it in a separate environment with ``actigamma==0.1.5`` and ``radioactivedecay==0.6.1``;
neither is needed at run time. With ``--check`` and ``xraydb==4.5.8`` it also compares the
attenuation with Elam's tables, which end at 800 keV.

Sources
-------
nuclides.json: emission lines of the UKAEA Decay2012 library (actigamma, Apache-2.0), half-lives
and branching of ICRP Publication 107 (radioactivedecay, MIT).
photons.json: mu/rho and mu_en/rho of NIST SRD 126 (Hubbell and Seltzer, public domain), for
concrete mu/rho of ANSI/ANS-6.4.3; build-up coefficients of ANSI/ANS-6.4.3-1991 (exposure in air,
geometric progression); H*(10)/Ka of ICRP Publication 74, table A.21.
"""

import argparse
import json
from pathlib import Path
from typing import Any

FOLDER = Path(__file__).resolve().parents[1] / 'src/rocsafe_radiation/rocsafe_radiation/tables'
# Photons of lower energy do not leave a capsule.
LOWEST_ENERGY_KEV = 15.0
# Lines that together weigh less than this in energy are dropped one by one.
SMALLEST_ENERGY_SHARE = 2e-5
# Parent, then the members of its chain whose photons come with it in equilibrium, each with the
# fraction of the decays of the parent that passes through it.
CHAINS = {
    'Am-241': (('Am241', 1.0),),
    'Ba-133': (('Ba133', 1.0),),
    'Co-57': (('Co57', 1.0),),
    'Co-60': (('Co60', 1.0),),
    'Cs-137': (('Cs137', 1.0), ('Ba137m', 0.94399)),
    'Eu-152': (('Eu152', 1.0),),
    'I-131': (('I131', 1.0),),
    'Ir-192': (('Ir192', 1.0),),
    'Ra-226': (('Ra226', 1.0), ('Rn222', 1.0), ('Pb214', 1.0), ('Bi214', 1.0)),
    'Se-75': (('Se75', 1.0),),
    'Tc-99m': (('Tc99m', 1.0),),
}


def nuclides() -> dict[str, Any]:
    """Return lines and half-lives of all nuclides."""
    import actigamma
    import radioactivedecay

    library = actigamma.Decay2012Database()
    return {
        name: {
            'half_life_s': float(f'{radioactivedecay.Nuclide(name).half_life("s"):.6g}'),
            'lines_kev': _lines(library, members),
        }
        for name, members in CHAINS.items()
    }


def _lines(library: Any, members: tuple[tuple[str, float], ...]) -> list[list[float]]:
    found = []
    for member, branching in members:
        for kind in ('gamma', 'x-ray'):
            if not library.hastype(member, kind):
                continue
            energies_ev = library.getenergies(member, spectype=kind)
            intensities = library.getintensities(member, spectype=kind)
            found += [
                (float(energy) / 1e3, float(intensity) * branching)
                for energy, intensity in zip(energies_ev, intensities, strict=True)
            ]
    lines = [line for line in found if line[0] >= LOWEST_ENERGY_KEV]
    total = sum(energy * intensity for energy, intensity in lines)
    return [
        [round(energy, 2), float(f'{intensity:.4g}')]
        for energy, intensity in sorted(lines)
        if energy * intensity >= SMALLEST_ENERGY_SHARE * total
    ]


NIST_ENERGIES_KEV = (
    15, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1250, 1500, 2000,
    3000,
)  # fmt: skip
AIR = (
    1.614, 0.7779, 0.3538, 0.2485, 0.2080, 0.1875, 0.1662, 0.1541, 0.1356, 0.1233, 0.1067, 0.09549,
    0.08712, 0.08055, 0.07074, 0.06358, 0.05687, 0.05175, 0.04447, 0.03581,
)  # fmt: skip
AIR_ENERGY_ABSORPTION = (
    1.334, 0.5389, 0.1537, 0.06833, 0.04098, 0.03041, 0.02407, 0.02325, 0.02496, 0.02672, 0.02872,
    0.02949, 0.02966, 0.02953, 0.02882, 0.02789, 0.02666, 0.02547, 0.02345, 0.02057,
)  # fmt: skip
WATER = (
    1.673, 0.8096, 0.3756, 0.2683, 0.2269, 0.2059, 0.1837, 0.1707, 0.1505, 0.1370, 0.1186, 0.1061,
    0.09687, 0.08956, 0.07865, 0.07072, 0.06323, 0.05754, 0.04942, 0.03969,
)  # fmt: skip
IRON = (
    57.08, 25.68, 8.176, 3.629, 1.958, 1.205, 0.5952, 0.3717, 0.1964, 0.1460, 0.1099, 0.09400,
    0.08414, 0.07704, 0.06699, 0.05995, 0.05350, 0.04883, 0.04265, 0.03621,
)  # fmt: skip
CONCRETE_ENERGIES_KEV = (
    15, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1500, 2000, 3000
)  # fmt: skip
CONCRETE = (
    8.075, 3.510, 1.142, 0.5683, 0.3649, 0.2746, 0.2001, 0.1702, 0.1397, 0.1249, 0.1072, 0.09572,
    0.08728, 0.0807, 0.07085, 0.06368, 0.05187, 0.04472, 0.03646,
)  # fmt: skip
# With the K edge at 88.0 keV as two entries.
LEAD_ENERGIES_KEV = (
    20, 30, 40, 50, 60, 80, 88.0, 88.01, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1250, 1500,
    2000, 3000,
)  # fmt: skip
LEAD = (
    86.36, 30.32, 14.36, 8.041, 5.021, 2.419, 1.910, 7.683, 5.549, 2.014, 0.9985, 0.4031, 0.2323,
    0.1614, 0.1248, 0.08870, 0.07102, 0.05876, 0.05222, 0.04606, 0.04234,
)  # fmt: skip
MATERIALS = {
    'air': (1.205e-3, NIST_ENERGIES_KEV, AIR),
    'water': (1.0, NIST_ENERGIES_KEV, WATER),
    'iron': (7.87, NIST_ENERGIES_KEV, IRON),
    'concrete': (2.3, CONCRETE_ENERGIES_KEV, CONCRETE),
    'lead': (11.34, LEAD_ENERGIES_KEV, LEAD),
}
KERMA_TO_DOSE = (
    (15, 0.26), (20, 0.61), (30, 1.10), (40, 1.47), (50, 1.67), (60, 1.74), (80, 1.72),
    (100, 1.65), (150, 1.49), (200, 1.40), (300, 1.31), (400, 1.26), (500, 1.23), (600, 1.21),
    (800, 1.19), (1000, 1.17), (1500, 1.15), (2000, 1.14), (3000, 1.13),
)  # fmt: skip
# Energy in keV, then b, c, a, X, d of K(x) = c x^a + d (tanh(x/X - 2) - tanh -2)/(1 - tanh -2).
BUILDUP = {
    'air': (
        (15, 1.17, 0.459, 0.175, 13.73, -0.0862),
        (20, 1.407, 0.512, 0.161, 14.4, -0.0819),
        (30, 2.292, 0.693, 0.102, 13.34, -0.0484),
        (40, 3.39, 1.052, -0.004, 19.76, -0.0068),
        (50, 4.322, 1.383, -0.071, 13.51, 0.027),
        (60, 4.837, 1.653, -0.115, 13.66, 0.0511),
        (80, 4.929, 1.983, -0.159, 13.74, 0.073),
        (100, 4.58, 2.146, -0.178, 12.83, 0.0759),
        (150, 3.894, 2.148, -0.173, 14.46, 0.0698),
        (200, 3.345, 2.147, -0.176, 14.08, 0.0719),
        (300, 2.887, 1.99, -0.16, 14.13, 0.0633),
        (400, 2.635, 1.86, -0.146, 14.24, 0.0583),
        (500, 2.496, 1.736, -0.13, 14.32, 0.0505),
        (600, 2.371, 1.656, -0.12, 14.27, 0.0472),
        (800, 2.207, 1.532, -0.103, 14.12, 0.0425),
        (1000, 2.102, 1.428, -0.086, 14.35, 0.0344),
        (1500, 1.939, 1.265, -0.057, 14.24, 0.0232),
        (2000, 1.835, 1.173, -0.039, 14.07, 0.0161),
        (3000, 1.712, 1.051, -0.011, 13.67, 0.0024),
    ),
    'water': (
        (15, 1.182, 0.463, 0.175, 14.23, -0.0908),
        (20, 1.427, 0.549, 0.143, 14.86, -0.0707),
        (30, 2.335, 0.736, 0.087, 13.28, -0.0419),
        (40, 3.477, 1.117, -0.019, 11.67, 0.0026),
        (50, 4.461, 1.457, -0.084, 13.62, 0.0341),
        (60, 4.983, 1.73, -0.126, 13.64, 0.0561),
        (80, 5.059, 2.059, -0.168, 13.67, 0.077),
        (100, 4.663, 2.221, -0.186, 13.33, 0.0826),
        (150, 3.897, 2.242, -0.185, 14.19, 0.0777),
        (200, 3.478, 2.154, -0.176, 14.5, 0.0774),
        (300, 2.92, 2.022, -0.164, 14.21, 0.0655),
        (400, 2.66, 1.882, -0.149, 14.24, 0.0595),
        (500, 2.5, 1.766, -0.135, 14.33, 0.0546),
        (600, 2.377, 1.679, -0.124, 14.23, 0.0503),
        (800, 2.212, 1.544, -0.105, 14.36, 0.0437),
        (1000, 2.103, 1.441, -0.089, 14.22, 0.0378),
        (1500, 1.939, 1.269, -0.058, 14.52, 0.0246),
        (2000, 1.839, 1.173, -0.039, 14.07, 0.0161),
        (3000, 1.71, 1.056, -0.013, 11.82, 0.0047),
    ),
    'iron': (
        (15, 1.004, 1.561, -0.554, 5.6, 0.3524),
        (20, 1.012, 0.13, 0.62, 11.39, -0.6162),
        (30, 1.028, 0.374, 0.19, 29.34, -0.317),
        (40, 1.058, 0.336, 0.248, 11.65, -0.1188),
        (50, 1.099, 0.366, 0.232, 14.01, -0.1354),
        (60, 1.148, 0.405, 0.208, 14.17, -0.1142),
        (80, 1.267, 0.47, 0.18, 14.48, -0.0974),
        (100, 1.389, 0.557, 0.144, 14.11, -0.0791),
        (150, 1.66, 0.743, 0.079, 14.12, -0.0476),
        (200, 1.839, 0.911, 0.034, 13.23, -0.0334),
        (300, 1.973, 1.095, -0.009, 11.86, -0.0183),
        (400, 1.992, 1.187, -0.027, 10.72, -0.014),
        (500, 1.967, 1.24, -0.039, 8.34, -0.0074),
        (600, 1.947, 1.247, -0.04, 8.2, -0.0096),
        (800, 1.906, 1.233, -0.038, 7.93, -0.011),
        (1000, 1.841, 1.25, -0.048, 19.49, 0.014),
        (1500, 1.75, 1.197, -0.04, 15.9, 0.011),
        (2000, 1.712, 1.123, -0.021, 7.97, -0.0057),
        (3000, 1.627, 1.059, -0.005, 11.99, -0.0132),
    ),
    'concrete': (
        (15, 1.029, 0.364, 0.24, 14.12, -0.1704),
        (20, 1.067, 0.389, 0.214, 12.68, -0.1126),
        (30, 1.212, 0.421, 0.201, 14.12, -0.1079),
        (40, 1.455, 0.493, 0.171, 14.53, -0.0925),
        (50, 1.737, 0.628, 0.115, 15.82, -0.06),
        (60, 2.125, 0.664, 0.118, 11.9, -0.0615),
        (80, 2.557, 0.895, 0.042, 14.37, -0.0413),
        (100, 2.766, 1.069, 0.001, 12.64, -0.0251),
        (150, 2.824, 1.315, -0.049, 8.66, -0.0048),
        (200, 2.716, 1.43, -0.07, 18.52, 0.0108),
        (300, 2.522, 1.492, -0.082, 16.59, 0.0161),
        (400, 2.372, 1.494, -0.085, 15.96, 0.0194),
        (500, 2.271, 1.466, -0.082, 16.25, 0.0195),
        (600, 2.192, 1.434, -0.078, 17.02, 0.0199),
        (800, 2.066, 1.386, -0.073, 15.07, 0.0202),
        (1000, 1.982, 1.332, -0.065, 15.38, 0.0193),
        (1500, 1.848, 1.227, -0.047, 16.41, 0.016),
        (2000, 1.775, 1.154, -0.033, 14.35, 0.01),
        (3000, 1.671, 1.054, -0.01, 10.47, -0.0008),
    ),
    'lead': (
        (15, 1.007, 0.322, 0.246, 13.67, -0.103),
        (20, 1.007, 0.322, 0.246, 13.67, -0.103),
        (30, 1.007, 0.322, 0.246, 13.67, -0.103),
        (40, 1.014, 0.317, 0.245, 14.95, -0.0867),
        (50, 1.023, 0.312, 0.252, 14.17, -0.1005),
        (60, 1.033, 0.32, 0.26, 13.89, -0.1223),
        (80, 1.058, 0.362, 0.233, 13.91, -0.1127),
        (88, 1.067, 0.382, 0.22, 14.14, -0.1048),
        (89, 2.368, 1.58, 0.075, 12.44, -0.0635),
        (90, 2.187, 1.693, 0.05, 18.21, -0.0415),
        (100, 1.93, 1.499, 0.061, 29.65, -0.1162),
        (110, 1.821, 1.196, 0.102, 16.64, -0.0756),
        (120, 1.644, 0.97, 0.136, 16.1, -0.1135),
        (130, 1.54, 0.718, 0.194, 15.69, -0.1685),
        (140, 1.472, 0.479, 0.273, 16.5, -0.2153),
        (150, 1.402, 0.352, 0.269, 17.09, -0.0247),
        (160, 1.334, 0.329, 0.145, 11.38, -0.0643),
        (200, 1.201, 0.158, 0.426, 14.12, -0.1873),
        (300, 1.148, 0.422, 0.203, 13.49, -0.1013),
        (400, 1.187, 0.562, 0.137, 14.19, -0.0706),
        (500, 1.233, 0.634, 0.109, 14.2, -0.0556),
        (600, 1.269, 0.685, 0.089, 13.78, -0.044),
        (800, 1.329, 0.759, 0.065, 13.69, -0.0317),
        (1000, 1.367, 0.811, 0.051, 13.67, -0.0283),
        (1500, 1.369, 0.942, 0.02, 14.65, -0.0207),
        (2000, 1.384, 0.98, 0.014, 13.51, -0.0216),
        (3000, 1.367, 1.006, 0.017, 13.33, -0.0377),
    ),
}


def photons() -> dict[str, Any]:
    """Return attenuation, energy absorption, dose conversion and build-up."""
    return {
        'materials': {
            name: {
                'density_g_cm3': density,
                'energies_kev': energies,
                'mass_attenuation_cm2_g': values,
                'buildup': BUILDUP[name],
            }
            for name, (density, energies, values) in MATERIALS.items()
        },
        'air_energy_absorption': {
            'energies_kev': NIST_ENERGIES_KEV,
            'mass_energy_absorption_cm2_g': AIR_ENERGY_ABSORPTION,
        },
        'dose_per_kerma': {
            'energies_kev': [energy for energy, _ in KERMA_TO_DOSE],
            'sv_per_gy': [ratio for _, ratio in KERMA_TO_DOSE],
        },
    }


def check() -> None:
    """Print the largest difference from Elam's tables, 30 to 800 keV, of each pure material."""
    import numpy as np
    import xraydb

    formulas = {'air': 'N1.5606O0.4204Ar0.0094', 'water': 'H2O', 'iron': 'Fe', 'lead': 'Pb'}
    for name, formula in formulas.items():
        density, energies, values = MATERIALS[name]
        inside = [i for i, energy in enumerate(energies) if 30 <= energy <= 800]
        elam = xraydb.material_mu(
            formula, np.array([energies[i] for i in inside]) * 1e3, density=density
        )
        ours = np.array([values[i] for i in inside]) * density
        differences = np.abs(ours / elam - 1.0)
        worst = int(np.argmax(differences))
        print(f'{name}: {differences[worst]:.2%} at {energies[inside[worst]]} keV')


def write(name: str, content: dict[str, Any]) -> None:
    """Write a table as JSON, one entry of the second level on each line."""
    lines = [
        f'  {json.dumps(key)}: {{\n'
        + ',\n'.join(f'    {json.dumps(inner)}: {json.dumps(v)}' for inner, v in value.items())
        + '\n  }'
        for key, value in content.items()
    ]
    (FOLDER / name).write_text('{\n' + ',\n'.join(lines) + '\n}\n')


def main() -> None:
    """Write both tables, or check."""
    parser = argparse.ArgumentParser(description=__doc__.partition('\n')[0])
    parser.add_argument('--check', action='store_true', help='compare with xraydb')
    if parser.parse_args().check:
        check()
        return
    write('nuclides.json', nuclides())
    write('photons.json', photons())


if __name__ == '__main__':
    main()
