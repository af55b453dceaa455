"""Volumes as the field writes them: MSH of version 1 and without a header, parts that are not joined, other units."""

from __future__ import annotations

import numpy as np
import pytest

import palpate
from palpate.base.errors import MeshError, PalpateWarning
from palpate.world.tissue import TetMesh, load, save
from palpate.world.tissue.blocks import block

pytest.importorskip("meshio", reason="extra tissue")

CELLS, SIZE = (2, 3, 2), (0.02, 0.03, 0.02)


def old_text(version, nodes, tets, groups, numbers):
    """A file in Gmsh's old forms, in mm, whose nodes have any numbers, with triangles beside the tetrahedra."""
    at = "".join(f"{k} {x:.9g} {y:.9g} {z:.9g}\n" for k, (x, y, z) in zip(numbers, 1e3 * nodes, strict=True))
    rows = []
    for k, (tet, group) in enumerate(zip(numbers[tets], groups, strict=True)):
        corners = " ".join(map(str, tet))
        head = f"{group} 7 4" if version == 1 else f"2 {group} 7"
        rows.append(f"{k + 2} 4 {head} {corners}")
    triangle = " ".join(map(str, numbers[tets[0, :3]]))
    rows.insert(0, f"1 2 {'9 7 3' if version == 1 else '2 9 7'} {triangle}")
    names = ("NOD", "ENDNOD", "ELM", "ENDELM") if version == 1 else ("Nodes", "EndNodes", "Elements", "EndElements")
    listed = "\n".join(rows)
    return f"${names[0]}\n{len(nodes)}\n{at}${names[1]}\n${names[2]}\n{len(rows)}\n{listed}\n${names[3]}\n"


@pytest.mark.parametrize("version", [1, 2], ids=["version 1", "version 2 without header"])
def test_old_gmsh_files_are_read_as_what_they_say(tmp_path, version):
    nodes, tets = block(CELLS, SIZE)
    rng = np.random.default_rng(version)
    numbers = rng.permutation(5000)[: len(nodes)] + 1
    groups = rng.choice([3, 11], len(tets))
    (tmp_path / "old.msh").write_text(old_text(version, nodes, tets, groups, numbers))
    mesh = load(tmp_path / "old.msh")
    np.testing.assert_allclose(mesh.nodes, nodes, atol=1e-11)
    np.testing.assert_array_equal(mesh.tets, tets)
    np.testing.assert_array_equal(mesh.region, groups == 11)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda t: t.replace("$ENDNOD", "")[:400], "announces 36 rows|without a readable list"),
        (lambda t: t.replace("$ELM", "$OTHER"), "MSH 1 without a readable list"),
        (lambda t: t.replace(" 4 3 7 4 ", " 4 3 7 4 99999 "), "without a readable list"),
        (lambda t: t.replace("36\n1 ", "36\n77 ", 1), "names node 1, which the file does not have"),
        (lambda t: t.replace(" 4 3 7 4 ", " 11 3 7 4 "), "no tetrahedra; it has elements of Gmsh's types 2, 11"),
    ],
)
def test_damaged_old_files_are_refused_with_the_cause_and_the_tool(tmp_path, change, words):
    nodes, tets = block(CELLS, SIZE)
    text = change(old_text(1, nodes, tets, np.full(len(tets), 3), np.arange(1, len(nodes) + 1)))
    (tmp_path / "old.msh").write_text(text)
    with pytest.raises(MeshError, match=words) as error:
        load(tmp_path / "old.msh")
    assert error.value.mend


def test_other_order_and_joined_nodes_are_told_on_loading(tmp_path):
    import meshio

    nodes, tets = block(CELLS, SIZE)
    both = np.vstack([nodes, nodes + np.array([0.0, 0.0, 0.02])])
    cells = np.vstack([tets, tets + len(nodes)])[:, [0, 2, 1, 3]]
    meshio.write(tmp_path / "two.vtk", meshio.Mesh(1e3 * both, [("tetra", cells)]))
    with pytest.warns(PalpateWarning) as told:
        mesh = load(tmp_path / "two.vtk")
    words = " ".join(str(one.message) for one in told)
    assert "144 of 144 tetrahedra list their nodes in the other order: turned" in words
    assert "12 nodes lie at the place of another one: joined" in words
    assert mesh.parts == 1


PADS = """
objects:
  - name: pads
    box: {size: [0.06, 0.06, 0.04]}
    unit: m
    tissue: {volume: cube.vtk, preset: liver, fixed: [{at: [0, 0, -0.02], box: [0.2, 0.2, 0.002]}]}
"""


def build(tmp_path, nodes, tets, text=PADS, unit="m"):
    from palpate.scene.rig import build as build_rig

    save(TetMesh(nodes, tets), tmp_path / "cube.vtk", unit=unit)
    (tmp_path / "pads.yaml").write_text(text)
    return build_rig(palpate.Scene.load(tmp_path / "pads.yaml"))


def test_a_part_that_nothing_holds_is_told(tmp_path):
    nodes, tets = block((3, 3, 2), (0.06, 0.06, 0.02))
    nodes = nodes - [0.03, 0.03, 0.02]
    both, all_tets = np.vstack([nodes, nodes + np.array([0.0, 0.0, 0.021])]), np.vstack([tets, tets + len(nodes)])
    with pytest.warns(PalpateWarning, match=r"2 parts that share no node, and nothing holds 1 of them with 108 of 216"):
        build(tmp_path, both, all_tets)
    with pytest.warns(PalpateWarning, match="nothing holds 'pads'"):
        build(tmp_path, both, all_tets, PADS.replace(", fixed: [{at: [0, 0, -0.02], box: [0.2, 0.2, 0.002]}]", ""))


def test_a_volume_in_another_unit_than_its_object_is_refused(tmp_path):
    nodes, tets = block((3, 3, 2), (0.06, 0.06, 0.04))
    with pytest.raises(MeshError, match=r"the volume is 6e\+04 mm wide, its object 60 mm"):
        build(tmp_path, nodes - [0.03, 0.03, 0.02], tets, unit="mm")
