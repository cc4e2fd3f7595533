#!/usr/bin/env python3
"""Water at rest below a level of any place and shape, stages that drain at once or until they have consolidated, and the lines
on both. Consolidation by Terzaghi (1943), doi:10.1002/9780470172766.

Quick.
"""
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from talus_test import Test  # noqa: E402

HERE = Path(__file__).resolve().parent
FILL, COLUMN, QUARTER = HERE / "fill_on_clay.yaml", HERE / "drained_column.yaml", HERE / "quarter.yaml"
SLOPE = HERE / "slope_still.yaml"
GAMMA, LOAD, CELL = 1e4, 20e3, 0.5
MODULUS = 1e7 * 0.75 / (1.25 * 0.5)  # constrained, of the column


def fill(test):
    """The load of dry fill becomes effective stress: settlement of clay under it, less the open water that clay sinks from."""
    stiffness = 2e6 * 0.75 / (1.25 * 0.5)
    for shape in ("linear", "gimp", "gimp_bspline2", "bspline2", "bspline3"):
        for level in (3.0, 2.75) if shape != "linear" else (3.0,):
            run = test.run(FILL, mpm_shape=shape, mpm_water_level=level, mpm_material_f_permeability=1e-8)
            y, excess = run.table("position")[:, 1], run.table("pressure") - GAMMA * (level - run.table("position")[:, 1])
            label = f"fill.{shape}.{level}"
            test.check(label + ".pressure", np.max(np.abs(excess[y < level - 2 * CELL])), None, 0.005 * LOAD)
            test.check(label + ".above", np.max(np.abs(run.table("pressure")[y > level + CELL])), None, 0.06 * GAMMA * CELL)
            settled = -run.results.column("track_t_uy")[-1]
            test.near(label + ".settlement", settled, 2.75 * LOAD / stiffness, 0.05)
            if (shape, level) == ("gimp", 3.0):
                first = settled
            test.near(label + ".shapes", settled, first if shape != "linear" else settled, 0.01)
    run = test.run(FILL, mpm_water_above="suction")
    y = run.table("position")[:, 1]
    test.check("fill.suction", np.max(np.abs(run.table("pressure") - GAMMA * (3.0 - y))), None, 0.005 * LOAD)
    several = test.run(FILL, ranks=3, mpm_water_level=2.75)
    alone = test.run(FILL, mpm_water_level=2.75)
    test.check("fill.on_3", abs(several.results.column("track_t_uy")[-1] - alone.results.column("track_t_uy")[-1]), None, 1e-10)


def table(test):
    """A level table is a level, with its ramp; a sloping one starts hydrostatic in each column."""
    level = test.run(FILL, mpm_water_level=2.75, mpm_water_ramp="2:1,1e8:0.8")
    text = FILL.read_text(encoding="utf-8").replace("level: 3}", 'table: "-1,2.75,0.5,2.75,7,2.75", table_ramp: "2:1,1e8:0.8"}')
    scene = test.folder() / "table.yaml"
    scene.write_text(text, encoding="utf-8")
    line = test.run(scene)
    test.check("table.level", np.max(np.abs(line.table("pressure") - level.table("pressure"))), None, 1e-6)
    scene.write_text(text.replace("-1,2.75,0.5,2.75,7,2.75", "0,1.5,1,2.5").replace("rest,lift,wait", "rest")
                     .replace("2:1,1e8:0.8", "0:1"), encoding="utf-8")
    rest = test.run(scene, mpm_stages="rest,lift,wait", mpm_stage_wait_time_end=1, mpm_stage_wait_time_step=1)
    x, y = rest.results.initial["position0"].T[:2]
    pressure, hydrostatic = rest.results.state(0)["pressure"], GAMMA * (1.5 + x - y)
    deep = hydrostatic > 1.5 * GAMMA * CELL
    test.check("table.start", np.max(np.abs(pressure - hydrostatic)[deep]), None, 1e-6)


def slope(test):
    """A level that meets a slope, open water above its foot: nothing moves."""
    for shape in ("gimp", "gimp_bspline2"):
        run = test.run(SLOPE, mpm_shape=shape)
        y, label = run.table("position")[:, 1], f"slope.{shape}"
        deep = y < 3.7 - 2 * CELL
        test.check(label + ".pressure", np.max(np.abs(run.table("pressure") - GAMMA * (3.7 - y))[deep]), None, 1e-6 * LOAD)
        test.check(label + ".moved", np.max(np.abs(run.table("displacement"))), None, 1e-9)
        test.check(label + ".flux", np.max(np.abs(run.table("flux"))) / (1e-11 / 1e-3 * GAMMA), None, 1e-10)


def drained(test):
    """At once: the settlement of the skeleton, and no excess; a steady flow; sealed ground bears the load by its skeleton, too."""
    run = test.run(COLUMN, mpm_stage_load_drained="true")
    test.check("drained.excess", np.max(np.abs(run.table("pressure"))), None, 1e-3)
    y = run.results.initial["position0"][:, 1]
    test.check("drained.settlement", np.max(np.abs(run.table("displacement")[:, 1] + 10e3 * y / MODULUS)), None, 1e-9)
    test.check("drained.line", "drained stage" in run.output, 1)
    undrained = test.run(COLUMN)
    test.check("undrained.line", "undrained clay" in undrained.output, 1)
    test.check("undrained.moved", np.max(np.abs(undrained.table("displacement"))), None, 0.02 * 10e3 * 4 / MODULUS)
    late = test.run(COLUMN, mpm_stages="load,later", mpm_stage_later_drained="true")
    test.check("drained_later.excess", np.max(np.abs(late.table("pressure"))), None, 1e-3)
    flow = test.run(COLUMN, mpm_stage_load_drained="true", mpm_bcs="base,sides,bottom", mpm_bc_bottom_region="box",
                    mpm_bc_bottom_lower="0,0", mpm_bc_bottom_upper="1,0", mpm_bc_bottom_components="p", mpm_bc_bottom_value=8e3)
    test.check("drained.flow", np.max(np.abs(flow.table("pressure") - 2e3 * (4.0 - y))), None, 1.0)
    test.near("drained.outflow", flow.results.column("outflow_top")[-1], 1e-14 / 1e-3 * 2e3, 1e-3)
    sealed = test.run(COLUMN, mpm_stage_load_drained="true", mpm_surface_top_drained="false", mpm_body_clay_initial_pressure=3e3,
                      mpm_material_clay_type="hencky")
    test.check("sealed.pressure", np.max(np.abs(sealed.table("pressure") - 3e3)), None, 1.0)


def until(test):
    """Terzaghi: 95 % at T = 1.129; the stage ends there, and the next one begins."""
    time = 16.0 / (1e-11 * MODULUS)
    run = test.run(COLUMN, mpm_stages="load,next", mpm_stage_load_until_consolidation=0.95, mpm_stage_load_time_end=3 * time,
                   mpm_stage_load_time_step=time / 100, mpm_time_scheme="second", mpm_stage_next_time_end=time / 100,
                   mpm_stage_next_time_step=time / 100)
    ends, stage = run.results.column("time"), run.results.column("stage")
    test.near("until.time", ends[stage == 1][-1], 1.129 * time, 0.02)
    test.check("until.degree", run.results.column("consolidation")[stage == 1][-1], 0.95, 0.953)
    test.check("until.next", int(stage[-1]), 2, 2)
    test.check("until.line", "stage load ends 95" in run.output, 1)
    short = test.run(COLUMN, mpm_stage_load_until_consolidation=0.95, mpm_stage_load_time_end=0.1 * time,
                     mpm_stage_load_time_step=0.01 * time)
    test.check("until.over", "its time being over" in short.output, 1)


def lines(test):
    """Water that would boil, and pores that close."""
    run = test.run(COLUMN, mpm_surface_top_traction="0,300e3")
    test.check("boils", "water boils" in run.errors, 1)
    test.check("boils.once", run.errors.count("water boils"), 1, 1)
    run = test.run(COLUMN, status=3, mpm_surface_top_traction="0,-20e6", mpm_surface_top_ramp="0:0,1:1", mpm_stage_load_drained="true",
                   mpm_material_clay_type="neo_hookean", mpm_material_clay_porosity=0.1, mpm_stage_load_time_step=0.05)
    test.check("closed", "pores closed at (" in run.errors, 1)


def symmetry(test):
    """All sides but for planes of symmetry are the two that look outward."""
    every = test.run(QUARTER)
    test.check("symmetry.line", "planes of symmetry left out, whose nodes are held along the normal by x, y" in every.output, 1)
    text = QUARTER.read_text(encoding="utf-8").replace("surfaces: rim", "surfaces: right,up")
    line = next(line for line in text.splitlines() if "surface_rim" in line)
    both = [line.replace("rim", name).replace("side: all", f'side: "{side}"') for name, side in (("right", "+x"), ("up", "+y"))]
    scene = test.folder() / "outward.yaml"
    scene.write_text(text.replace(line, "\n".join(both)), encoding="utf-8")
    outward = test.run(scene)
    test.check("symmetry.pressure", np.max(np.abs(every.table("pressure") - outward.table("pressure"))), None, 1e-9)
    test.check("symmetry.middle", np.max(every.table("pressure")), 900.0)


def main():
    with Test() as test:
        fill(test)
        table(test)
        slope(test)
        drained(test)
        until(test)
        lines(test)
        symmetry(test)


if __name__ == "__main__":
    main()
