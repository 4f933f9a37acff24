"""Random NURBS surfaces."""

import numpy as np
from hypothesis import strategies as st

from lodbench.datasets_gen.nurbs_surface import NurbsModel, NurbsSurface


def random_knots(degree, spans, random, most=None):
    """Clamped, uneven inner knots that stand there 1 to `most` or degree times."""
    inner = np.sort(random.uniform(0, 1, spans - 1))
    times = random.integers(1, (most or degree) + 1, spans - 1)
    inner = inner.repeat(times)
    return np.concatenate([np.zeros(degree + 1), inner, np.ones(degree + 1)])


def random_surface(degrees, spans, seed, rational=True):
    random = np.random.default_rng(seed)
    knots = [random_knots(p, s, random) for p, s in zip(degrees, spans, strict=True)]
    shape = tuple(len(k) - p - 1 for k, p in zip(knots, degrees, strict=True))
    x, y = np.meshgrid(*(np.linspace(-1, 1, n) for n in shape), indexing="ij")
    points = np.stack([x, y, random.normal(0, 0.3, shape)], axis=2)
    weights = random.uniform(0.3, 3, shape) if rational else None
    return NurbsSurface(*degrees, *knots, points, weights)


@st.composite
def models(draw):
    """One to three surfaces of random degrees, spans, repeated knots and weights."""
    return NurbsModel(
        tuple(
            random_surface(
                (draw(st.integers(1, 7)), draw(st.integers(1, 7))),
                (draw(st.integers(1, 4)), draw(st.integers(1, 4))),
                draw(st.integers(0, 9999)),
                draw(st.booleans()),
            )
            for _ in range(draw(st.integers(1, 3)))
        )
    )


def folds(surface):
    """Has it knots that stand there as often as its degree, so that its tangents may jump?"""
    return any(
        np.unique(k[p + 1 : -p - 1], return_counts=True)[1].max(initial=0) >= p
        for k, p in ((surface.knots_u, surface.degree_u), (surface.knots_v, surface.degree_v))
    )
