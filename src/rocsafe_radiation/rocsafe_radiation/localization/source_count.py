# SPDX-License-Identifier: Apache-2.0
"""How many sources there are: fits of rising order, compared by their evidence."""

from rocsafe_radiation.localization.credibility import credible
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.hypothesis import Nuisance, Trial
from rocsafe_radiation.localization.hypothesis_values import OrderSearch
from rocsafe_radiation.readings.survey import Survey

LARGEST_ORDER = 4
# What may be wrong with "Poisson about a constant background, by the law of the dose rate".
# The ground varies over ways wider than a source shows, or over ways just as wide.
UNEVEN: Nuisance = {'background_std': 0.3}
ROLLING: Nuisance = {'background_std': 0.2, 'background_spacing_heights': 1.0}
GROUNDS = (UNEVEN, ROLLING)
# Another nuclide, other air: of a strong source, readings tell, and its place is moved.
TILTED: Nuisance = {'tilt_std': 0.4}
NUISANCES: tuple[Nuisance, ...] = (
    *GROUNDS,
    TILTED,
    {'rho': 0.05},
    UNEVEN | {'rho': 0.05},
    {'rho': 0.1},
    UNEVEN | {'rho': 0.1},
    ROLLING | {'rho': 0.1},
    {'rho': 0.2},
)
# Only where no source explains the readings.
SHADES: tuple[Nuisance, ...] = (
    {'rho': 0.05, 'shade': 0.3},
    {'rho': 0.1, 'shade': 0.3},
    {'rho': 0.1, 'shade': 0.6},
)
# A wall beside the sources, of which nobody knows, with and without other things about.
WALL: Nuisance = {'has_shield': True}
# Fits find the sharp edge of its shadow from a soft one.
FIRST_WALLS: tuple[Nuisance, ...] = (WALL | {'edge_sharpness': 6.0}, WALL)
ROUGH_WALLS: tuple[Nuisance, ...] = (WALL | {'rho': 0.2}, WALL | {'rho': 0.05, 'shade': 0.3})
# What at first glance explains the readings worse by this will not catch up.
HOPELESS = 30.0
# A single source with more evidence is not feigned by the ground.
STRONG_EVIDENCE = 60.0
# One with less would show no misfit beside a wall, only be elsewhere.
TELLING_EVIDENCE = 300.0
# Pearson's chi^2 beyond this many standard deviations says that something is wrong.
LARGEST_DISPERSION = 3.0
# Beyond this it may be that something is wrong with a weak source.
NOTABLE_DISPERSION = 0.5


def search(survey: Survey, setting: Setting, largest_order: int = LARGEST_ORDER) -> OrderSearch:
    """Return the best fits to `survey`, in the nuisance setting that explains it best.

    It begins with pure Poisson counts about a constant background. Where these do not explain the
    readings, or need sources, the other settings are tried, with at most as many sources; the
    evidence decides. Where the ground proves uneven, sources that it could
    feign do not count.
    """
    trial = Trial(survey, setting)
    plain = trial.orders({}, largest_order)
    if plain.dispersion >= LARGEST_DISPERSION:
        others = _of_misfit(trial, plain, largest_order)
    elif plain.order > 1:
        # Do fewer sources explain it as well, on uneven ground or with scattered readings?
        fewer = plain.order - 1
        tried = _promising(trial, NUISANCES, [plain], fewer)
        others = [trial.orders(one, fewer, plain) for one in tried]
        others += _walled(trial, plain, fewer, FIRST_WALLS)
    elif plain.order == 1:
        is_doubtful = plain.dispersion >= NOTABLE_DISPERSION
        is_weak = is_doubtful or plain.gain(1) < STRONG_EVIDENCE
        tried = _promising(trial, (*GROUNDS, TILTED) if is_weak else (TILTED,), [plain], 1)
        others = [trial.orders(one, 1, plain) for one in tried]
        if is_doubtful or plain.gain(1) < TELLING_EVIDENCE:
            others += _walled(trial, plain, 1, FIRST_WALLS)
    else:
        return plain
    return credible((plain, *others))


def _of_misfit(trial: Trial, plain: OrderSearch, largest_order: int) -> list[OrderSearch]:
    """Return searches in all settings that may explain what `plain` does not."""
    hidden = [] if largest_order == 0 else _walled(trial, plain, 1, (*FIRST_WALLS, *ROUGH_WALLS))
    tried = _promising(trial, (*SHADES, *NUISANCES), [plain, *hidden], largest_order)
    hidden += [trial.orders(one, largest_order, plain) for one in tried if one in SHADES]
    explained = [one.order for one in hidden if one.dispersion < LARGEST_DISPERSION]
    # No more sources than explain the readings already.
    most = max(explained, default=largest_order)
    return [*(trial.orders(one, most, plain) for one in tried if one not in SHADES), *hidden]


def _walled(
    trial: Trial, plain: OrderSearch, largest_order: int, walls: tuple[Nuisance, ...]
) -> list[OrderSearch]:
    """Return searches beside each of `walls`, each from the one before, until one explains all.

    The first has a soft edge, from which only what may catch up with `plain` is gone on.
    """
    found = [plain]
    for nuisance in walls:
        found.append(trial.orders(nuisance, largest_order, found[-1]))
        is_soft = len(found) == 2
        if is_soft and max(found[-1].scores) < max(plain.scores) - HOPELESS:
            break
        if not is_soft and found[-1].dispersion < NOTABLE_DISPERSION:
            break
    return found[1:]


def _promising(
    trial: Trial, nuisances: tuple[Nuisance, ...], known: list[OrderSearch], largest_order: int
) -> list[Nuisance]:
    """Return those of `nuisances` that may come near the best of them and of `known`.

    The first of `known` says where sources may be.
    """
    glances = [trial.glance(one, known[0], largest_order) for one in nuisances]
    best = max(*(max(one.scores) for one in known), *glances) - HOPELESS
    return [one for one, glance in zip(nuisances, glances, strict=True) if glance > best]
