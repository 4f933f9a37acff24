from dataclasses import replace

from lodbench.datasets_gen import nurbs
from lodbench.harness.measure import exact_views
from lodbench.harness.measure.figure import Seen
from lodbench.kernels.nurbs import rpns
from lodbench.kernels.system import run


def seen(device, model, params):
    prepared = rpns.Rpns(device, model, params)
    run(device, prepared)
    return Seen(device, prepared, model, params, prepared.check())


def test_culling_is_told_and_only_certified_culling_has_a_limit(device):
    model = nurbs.body(2, 3, (4, 5))
    found = seen(device, model, rpns.Params(0, culling="certified"))
    figure = exact_views.lost(found)
    assert (figure.value, figure.limit) == (
        0,
        0,
    ) and "KSQuads culled in 5 views" in figure.looked_at
    light = seen(device, model, rpns.Params(0, culling="light"))
    assert exact_views.lost(light).limit is None and exact_views.lost(light).value > 0


def test_holes_are_found_where_surfaces_are_left_out(device):
    model, params = nurbs.quilt(2, 2, 3), rpns.Params(4, culling="none")
    found = seen(device, model, params)
    figure = exact_views.holes(found)
    assert figure.value == 0 and int(figure.looked_at.split()[0].replace(",", "")) > 100
    three = nurbs.NurbsModel(model.surfaces[:3])
    other = replace(found, prepared=rpns.Rpns(device, three, params))
    assert exact_views.holes(other).value > 0


def test_open_edges_between_surfaces_are_those_of_tolerant_borders(device):
    model = nurbs.quilt(2, 2, 3)
    params = rpns.Params(6, culling="none", sampling="adaptive", pixel_area=16.0)
    figure = exact_views.seams(seen(device, model, params))
    assert (figure.value, figure.limit) == (0, 0)
    assert int(figure.looked_at.split()[0].replace(",", "")) > 100
    figure = exact_views.seams(seen(device, model, replace(params, edges="tolerant")))
    assert figure.value > 100 and figure.limit is None
