"""Faults of a mesh are counted, corrected if this is safe, and reported."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate import _core
from palpate.base.errors import MeshError, PalpateWarning
from palpate.world.mesh import Mesh

pytestmark = pytest.mark.filterwarnings(
    "ignore::palpate.base.errors.PalpateWarning"
)  # each test checks its own warnings

CUBE_V = 0.04 * np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
CUBE_T = np.array(
    [
        *([0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1]),
        *([2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]),
    ]
)


def volume(v, t) -> float:
    a, b, c = (v[t[:, k]] for k in range(3))
    return float(np.linalg.det(np.stack([a, b, c], axis=1)).sum() / 6)


def two(v=CUBE_V, t=CUBE_T, shift=0.1, scale=1.0, turn=False):
    """A cube and a second one, moved by `shift` [m], scaled, and inside out if `turn`."""
    return np.vstack([v, v * scale + shift]), np.vstack([t, (t[:, ::-1] if turn else t) + len(v)])


def test_valid_mesh_is_used_unchanged():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh = Mesh(CUBE_V, CUBE_T)
    assert mesh.report.findings == ()
    assert mesh.report.components == 1
    np.testing.assert_array_equal(
        np.sort(mesh.vertices[mesh.triangles].reshape(-1, 9)), np.sort(CUBE_V[CUBE_T].reshape(-1, 9))
    )


def test_degenerate_triangles_are_dropped_and_counted():
    collapsed, sliver = [0, 0, 1], [8, 9, 10]
    v = np.vstack([CUBE_V, [[0, 0, 0.1], [0, 0, 0.12], [0, 0, 0.15]]])
    with pytest.warns(PalpateWarning, match=r"2 degenerate triangles \(no area\): dropped"):
        mesh = Mesh(v, np.vstack([CUBE_T, [collapsed, sliver]]))
    assert mesh.report.degenerate == 2
    assert len(mesh.triangles) == 12


def test_duplicate_triangles_are_dropped_and_counted():
    with pytest.warns(PalpateWarning, match="3 duplicate triangles: dropped"):
        mesh = Mesh(CUBE_V, np.vstack([CUBE_T, CUBE_T[:2], np.roll(CUBE_T[4], 1)]))
    assert mesh.report.duplicate == 3
    assert mesh.report.watertight


def test_inverted_winding_is_corrected_and_reported():
    with pytest.warns(PalpateWarning, match=r"inverted winding: 12 triangles[\s\S]*enclosed volume came out negative"):
        mesh = Mesh(CUBE_V, CUBE_T[:, ::-1])
    assert volume(mesh.vertices, mesh.triangles) == pytest.approx(0.04**3)


@pytest.mark.parametrize("inverted", [[3], [0, 5, 7], list(range(7))])
def test_inconsistent_winding_is_corrected_and_reported(inverted):
    t = CUBE_T.copy()
    t[inverted] = t[inverted][:, ::-1]
    with pytest.warns(PalpateWarning, match="winding"):
        mesh = Mesh(CUBE_V, t)
    assert volume(mesh.vertices, mesh.triangles) == pytest.approx(0.04**3)
    assert mesh.report.watertight


def test_cavity_keeps_its_winding():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh = Mesh(*two(shift=0.01, scale=0.5, turn=True))
    assert mesh.report.volume_m3 == pytest.approx(0.04**3 - 0.02**3)
    assert mesh.report.components == 2


def test_inverted_part_of_a_mesh_is_corrected():
    with pytest.warns(PalpateWarning, match="inverted winding: 12 triangles"):
        mesh = Mesh(*two(turn=True))
    assert volume(mesh.vertices, mesh.triangles) == pytest.approx(2 * 0.04**3)


def test_moebius_strip_is_not_orientable():
    n = 12
    u = np.arange(n) * 2 * np.pi / n
    w = np.stack([np.cos(u / 2) * np.cos(u), np.cos(u / 2) * np.sin(u), np.sin(u / 2)], 1) * 0.01
    c = np.stack([np.cos(u), np.sin(u), 0 * u], 1) * 0.05
    v = np.vstack([c - w, c + w])
    t = []
    for i in range(n):
        a, b, c_, d = i, i + n, (i + 1) % n, (i + 1) % n + n
        if i == n - 1:
            c_, d = d, c_
        t += [[a, b, d], [a, d, c_]]
    with pytest.warns(PalpateWarning, match="the surface has no two sides"):
        Mesh(v, np.array(t))


def test_open_surface_is_reported_with_its_edges():
    with pytest.warns(
        PalpateWarning, match=r"the surface is open: 4 edges have one triangle only[\s\S]*close the holes"
    ):
        mesh = Mesh(CUBE_V, CUBE_T[2:])
    assert not mesh.report.watertight
    assert mesh.report.open_edges == 4


def test_edges_with_many_triangles_are_reported():
    with pytest.warns(PalpateWarning, match="edges are shared by more than two triangles"):
        mesh = Mesh(np.vstack([CUBE_V, [[0.01, 0.02, 0.06]]]), np.vstack([CUBE_T, [[1, 3, 8]]]))
    assert mesh.report.non_manifold_edges == 1


@pytest.mark.parametrize(("scale", "message"), [(1000, "unit: mm would make it 0.04 m"), (0.01, "scale the mesh")])
def test_implausible_size_is_reported_with_the_unit(scale, message):
    with pytest.warns(
        PalpateWarning, match=rf"the largest extent is .* m with unit m: is the unit right\?[\s\S]*{message}"
    ):
        Mesh(CUBE_V * scale, CUBE_T)


@pytest.mark.parametrize(
    ("vertices", "triangles", "message"),
    [
        (CUBE_V[:, :2], CUBE_T, r"vertices must have shape \(n, 3\). Got: \(8, 2\)"),
        (CUBE_V, CUBE_T[:, :2], r"triangles must have shape \(m, 3\). Got: \(12, 2\)"),
        (CUBE_V, CUBE_T.astype(float), "triangles must be integers. Got: float64"),
        (CUBE_V, CUBE_T + 1, r"names the vertices \[\d, \d, \d\]; the mesh has 8 vertices \(0 to 7\)"),
        (CUBE_V, CUBE_T - 1, r"the mesh has 8 vertices \(0 to 7\)"),
        (CUBE_V, np.empty((0, 3), int), "zero triangles"),
        ([["a", "b", "c"]], CUBE_T, "vertices are not numbers"),
        (CUBE_V * np.nan, CUBE_T, "8 of 8 vertices are not finite"),
        (CUBE_V, [[0, 0, 1]], "all 1 triangles are degenerate"),
        (CUBE_V, [[0, 1, 2**40]], "out of range"),
    ],
)
def test_invalid_arrays_are_rejected(vertices, triangles, message):
    with pytest.raises(MeshError, match=message):
        Mesh(vertices, triangles)


def test_arrays_may_have_any_memory_layout():
    mesh = Mesh(np.asfortranarray(CUBE_V), np.asfortranarray(CUBE_T))
    assert mesh.report.volume_m3 == pytest.approx(0.04**3)


def test_arrays_are_copied_and_read_only():
    mesh = Mesh(CUBE_V, CUBE_T)
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[0, 0] = 1.0


def test_degenerate_triangle_that_closes_the_surface_is_kept():
    """A T-junction: one side of an edge is split, and a triangle without area closes the surface."""
    middle, opposite = (0.5 * (CUBE_V[1] + CUBE_V[3])), CUBE_T[11]  # [1, 7, 3]: split its edge 3-1 at the middle
    assert opposite.tolist() == [1, 7, 3]
    v = np.vstack([CUBE_V, middle])
    t = np.vstack([CUBE_T[:11], [[1, 7, 8], [8, 7, 3], [1, 8, 3]]])
    mesh = Mesh(v, t)
    assert mesh.report.watertight
    assert mesh.report.degenerate == 0
    assert mesh.core.nearest(np.array([[0.02, 0.02, 0.02]]))[0][0] == pytest.approx(-0.02)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda v: np.vstack([v[:-1], [[1e300, 0, 0]]]), r"a vertex at \(1e\+300, 0, 0\) m is more than 1e\+09 m away"),
        (lambda v: v * 1e-12, r"its largest extent is 4e-14 m, less than 1e-09 m\n  mend: check the unit"),
        (lambda v: v + 1e9 * 0.99, r"it lies 9.9e\+08 m from its origin, where numbers are too coarse"),
    ],
)
def test_extents_beyond_the_precision_are_rejected_with_the_numbers(change, message):
    with pytest.raises(MeshError, match=message):
        Mesh(change(CUBE_V), CUBE_T)


def test_stray_vertex_is_reported():
    from palpate.world.shapes import analytic

    v, t = analytic.Sphere().mesh(1000)
    v = np.vstack([v, [[1e6, 2.0, 0.0]]])
    with pytest.raises(
        MeshError, match=r"half of its triangles are smaller than [\s\S]*stray vertex at \(1e\+06, 2, 0\) m"
    ):
        Mesh(v, np.vstack([t, [[0, 1, len(v) - 1]]]))


@pytest.mark.parametrize("exponent", [-6, -3, 0, 3, 6])
def test_mesh_of_any_scale_is_accepted(exponent):
    mesh = Mesh(CUBE_V / 0.04 * 10.0**exponent, CUBE_T)
    assert mesh.report.volume_m3 == pytest.approx(10.0 ** (3 * exponent))
    assert mesh.core.nearest(np.full((1, 3), 0.5 * 10.0**exponent))[0][0] == pytest.approx(-0.5 * 10.0**exponent)


def parts_of(t) -> int:
    """Reference: number of parts from sets of vertices, merged one triangle at a time."""
    parts: list[set[int]] = []
    for row in t.tolist():
        touching = [p for p in parts if p & set(row)]
        parts = [p for p in parts if not p & set(row)] + [set(row).union(*touching)]
    return len(parts)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_parts_agree_with_the_reference(seed):
    rng = np.random.default_rng(seed)
    v = rng.normal(size=(30, 3))
    t = np.array([rng.choice(30, 3, replace=False) for _ in range(rng.integers(1, 20))])
    assert Mesh(v, t).report.components == parts_of(t)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10_000), share=st.floats(0.0, 0.45))
def test_winding_is_restored_for_any_inverted_triangles(seed, share):
    """Reference: the volume of the closed form; all normals point outwards."""
    from palpate.world.shapes import analytic

    rng = np.random.default_rng(seed)
    v, t = analytic.Torus().mesh(200)
    inverted = rng.uniform(size=len(t)) < share
    t = np.where(inverted[:, None], t[:, ::-1], t)
    both = Mesh(np.vstack([v, v + 0.2]), np.vstack([t, t[:, ::-1] + len(v)]))
    assert both.report.watertight
    assert both.report.components == 2
    a, b, c = (both.vertices[both.triangles[:, k]] for k in range(3))
    middle = (a + b + c) / 3
    middle -= np.where(middle[:, 2:] > 0.1, 0.2, 0.0)
    n = np.cross(b - a, c - a)
    assert (np.einsum("ij,ij->i", n, analytic.Torus().distance(middle)[1]) > 0).all()


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_weld_keeps_the_surface(data):
    """Reference: numpy.unique on the rows."""
    n = data.draw(st.integers(3, 40))
    rng = np.random.default_rng(data.draw(st.integers(0, 1000)))
    v = rng.integers(-2, 3, (n, 3)) * 0.1
    t = rng.integers(0, n, (data.draw(st.integers(1, 60)), 3)).astype(np.int32)
    a, b, c = (v[t[:, k]] + 0.0 for k in range(3))
    apart = (a != b).any(1) & (b != c).any(1) & (c != a).any(1)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-12
    if not (apart & area).any():
        return
    mesh = _core.Mesh(v, t)
    corners = np.sort(np.round(mesh.vertices[mesh.triangles], 12), axis=1).reshape(-1, 9)
    expected = np.sort(np.round(v[t[apart & area]] + 0.0, 12), axis=1).reshape(-1, 9)
    assert {tuple(row) for row in expected} <= {tuple(row) for row in corners}
    assert len(mesh.vertices) == len(np.unique(v[t].reshape(-1, 3) + 0.0, axis=0))


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000))
def test_duplicates_are_counted_as_with_a_set(seed):
    rng = np.random.default_rng(seed)
    t = rng.integers(0, 5, (30, 3))
    t = t[(t[:, 0] != t[:, 1]) & (t[:, 1] != t[:, 2]) & (t[:, 0] != t[:, 2])].astype(np.int32)
    expected = {tuple(np.roll(row, -int(np.argmin(row)))) for row in t}
    assert len(t) - Mesh(rng.normal(size=(5, 3)), t).report.duplicate == len(expected)
