# SPDX-License-Identifier: Apache-2.0
"""How many sources there are: fits with 0, 1, 2 ... sources, compared by their evidence.

The plain model is Poisson counts about a constant background, with the law of the dose rate as
given. Where it fails, other settings are fitted, each with a nuisance that may explain the
readings: an uneven background, readings that scatter, another law, shielding.
"""

from rocsafe_radiation.localization.credibility import credible
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.hypothesis import Nuisance, Trial
from rocsafe_radiation.localization.hypothesis_values import OrderSearch
from rocsafe_radiation.readings.survey import RadiationSurvey

LARGEST_ORDER = 4
# The background varies over lengths wider than the response to a source, or as wide.
UNEVEN: Nuisance = {'background_std': 0.3}
ROLLING: Nuisance = {'background_std': 0.2, 'background_spacing_heights': 1.0}
GROUNDS = (UNEVEN, ROLLING)
# Another nuclide or other air: only readings of a strong source tell, and it moves the source.
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
# Readings that are shaded, each by itself; tried only where sources alone do not fit.
SHADES: tuple[Nuisance, ...] = (
    {'rho': 0.05, 'shade': 0.3},
    {'rho': 0.1, 'shade': 0.3},
    {'rho': 0.1, 'shade': 0.6},
)
# An unknown wall beside the sources, alone and with scattered or shaded readings.
WALL: Nuisance = {'has_shield': True}
# A fit with a soft edge of the shadow comes first: it leads the fit with a sharp edge.
FIRST_WALLS: tuple[Nuisance, ...] = (WALL | {'edge_sharpness': 6.0}, WALL)
ROUGH_WALLS: tuple[Nuisance, ...] = (WALL | {'rho': 0.2}, WALL | {'rho': 0.05, 'shade': 0.3})


def search(
    survey: RadiationSurvey, setting: Setting, largest_order: int = LARGEST_ORDER
) -> OrderSearch:
    """Return the fits to `survey` in the setting that has the most evidence.

    The plain model comes first. If it needs sources or does not explain the readings, the other
    settings are tried, with at most as many sources. Sources that an uneven background may imitate
    do not count, see `credible`.

    Parameters
    ----------
    survey
        Readings, merged into cells.
    setting
        What is known before; its nuisances are replaced.
    largest_order
        Most sources looked for.
    """
    trial, options = Trial(survey, setting), setting.search
    plain = trial.orders({}, largest_order)
    if plain.dispersion >= options.large_dispersion:
        others = _of_misfit(trial, plain, largest_order)
    elif plain.order > 1:
        # An uneven background or scattered readings may need fewer sources.
        fewer = plain.order - 1
        tried = _promising(trial, NUISANCES, [plain], fewer)
        others = [trial.orders(one, fewer, plain) for one in tried]
        others += _walled(trial, plain, fewer, FIRST_WALLS)
    elif plain.order == 1:
        is_doubtful = plain.dispersion >= options.notable_dispersion
        is_weak = is_doubtful or plain.gain(1) < options.strong_evidence
        tried = _promising(trial, (*GROUNDS, TILTED) if is_weak else (TILTED,), [plain], 1)
        others = [trial.orders(one, 1, plain) for one in tried]
        if is_doubtful or plain.gain(1) < options.telling_evidence:
            others += _walled(trial, plain, 1, FIRST_WALLS)
    else:
        return plain
    return credible((plain, *others))


def _of_misfit(trial: Trial, plain: OrderSearch, largest_order: int) -> list[OrderSearch]:
    """Return the fits of all settings that may explain the readings where `plain` does not."""
    hidden = [] if largest_order == 0 else _walled(trial, plain, 1, (*FIRST_WALLS, *ROUGH_WALLS))
    tried = _promising(trial, (*SHADES, *NUISANCES), [plain, *hidden], largest_order)
    hidden += [trial.orders(one, largest_order, plain) for one in tried if one in SHADES]
    limit = trial.setting.search.large_dispersion
    explained = [one.order for one in hidden if one.dispersion < limit]
    # If shielding explains the readings, more sources than it needs are not tried.
    most = max(explained, default=largest_order)
    return [*(trial.orders(one, most, plain) for one in tried if one not in SHADES), *hidden]


def _walled(
    trial: Trial, plain: OrderSearch, largest_order: int, walls: tuple[Nuisance, ...]
) -> list[OrderSearch]:
    """Return fits beside each of `walls`, each begun at the last, until one explains all.

    The first wall has a soft edge. If its fit is hopelessly behind `plain`, the others are left
    out.
    """
    options = trial.setting.search
    found = [plain]
    for nuisance in walls:
        found.append(trial.orders(nuisance, largest_order, found[-1]))
        is_soft = len(found) == 2
        if is_soft and max(found[-1].scores) < max(plain.scores) - options.hopeless_deficit:
            break
        if not is_soft and found[-1].dispersion < options.notable_dispersion:
            break
    return found[1:]


def _promising(
    trial: Trial, nuisances: tuple[Nuisance, ...], known: list[OrderSearch], largest_order: int
) -> list[Nuisance]:
    """Return those of `nuisances` whose rough fits come near the best evidence so far.

    Rough fits begin with the sources of the first of `known`.
    """
    glances = [trial.glance(one, known[0], largest_order) for one in nuisances]
    best = max(*(max(one.scores) for one in known), *glances)
    least = best - trial.setting.search.hopeless_deficit
    return [one for one, glance in zip(nuisances, glances, strict=True) if glance > least]
