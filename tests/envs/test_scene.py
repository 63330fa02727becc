"""Our compiled model against OGBench's, read at run time, in numbers and in motion."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest

from pigbench.envs import kinematics, robot
from pigbench.envs.physics.mujoco import MujocoPhysics
from pigbench.envs.scene import PROFILES, SUBSTEPS, Scene
from pigbench.errors import UserError

NAME = "cube-double"
GRIPPER = "ur5e/robotiq/"

# Our bodies -> OGBench's, where the names differ by more than a prefix.
BODIES = {
    "base": "ur5e/base",
    "shoulder": "ur5e/shoulder_link",
    "upper_arm": "ur5e/upper_arm_link",
    "forearm": "ur5e/forearm_link",
    "wrist_1": "ur5e/wrist_1_link",
    "wrist_2": "ur5e/wrist_2_link",
    "wrist_3": "ur5e/wrist_3_link",
    "gripper_mount": GRIPPER + "base_mount",
    "gripper_base": GRIPPER + "base",
    "right_silicone": GRIPPER + "right_silicone_pad",
    "left_silicone": GRIPPER + "left_silicone_pad",
    "cube_0": "object_0",
    "cube_1": "object_1",
}

# OGBench's colliding geoms -> ours.
GEOMS = {
    "floor": "floor",
    "wall_0": "wall_near",
    "wall_1": "wall_right",
    "wall_2": "wall_far",
    "wall_3": "wall_left",
    "object_0": "cube_0",
    "object_1": "cube_1",
} | {
    f"{GRIPPER}{side}_pad{i + 1}": f"{side}_pad_{i}" for side in ("right", "left") for i in range(2)
}

OPTIONS = [name for name in dir(mujoco.MjOption) if not name.startswith("_")]

# Fields of joints, degrees of freedom, actuators and tendons that may differ.
MAY_DIFFER = {
    "jnt_bodyid",  # bodies are numbered differently
    "dof_bodyid",
    "dof_length",  # read by sleeping bodies only
    "actuator_gainprm",  # below
}
FIELDS = [
    name
    for name in dir(mujoco.MjModel)
    if name.startswith(("jnt_", "dof_", "qpos_", "actuator_", "tendon_"))
    and not name.startswith("tendon_rgba")
    and name not in MAY_DIFFER
]


def forward(
    model: mujoco.MjModel, qpos: np.ndarray, qvel: np.ndarray | None = None, ctrl=None
) -> mujoco.MjData:
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    data.qvel[:] = 0 if qvel is None else qvel
    data.ctrl[:] = 0 if ctrl is None else ctrl
    mujoco.mj_forward(model, data)
    return data


@pytest.fixture(scope="module")
def models(scene, ogbench_env) -> tuple[mujoco.MjModel, mujoco.MjModel]:
    """Ours and OGBench's."""
    return scene(2).model, ogbench_env(NAME).model


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("num_cubes", [1, 2, 3, 4, 8])
def test_every_size_compiles(scene, num_cubes, profile):
    built = scene(num_cubes, profile)
    assert (built.model.nq, built.model.nv, built.model.nu) == (
        14 + 7 * num_cubes,
        14 + 6 * num_cubes,
        7,
    )
    names = [built.model.joint(i).name for i in range(built.model.njnt)]
    assert names[built.arm] == list(robot.ARM_JOINTS)
    assert names[built.driver] == "right_driver"
    assert names[14:] == [f"cube_{i}" for i in range(num_cubes)]
    assert built.cubes_qpos == slice(14, built.model.nq)


def test_unknown_profile_offers_the_nearest(scene):
    with pytest.raises(UserError, match=r"'exat': did you mean 'exact'"):
        scene(1, "exat")


@pytest.mark.parametrize("option", OPTIONS)
def test_options(models, option):
    ours, theirs = (getattr(model.opt, option) for model in models)
    np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize("field", FIELDS)
def test_joints_and_actuators(models, field):
    ours, theirs = (np.asarray(getattr(model, field), float) for model in models)
    np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-12)


def test_actuator_gains(models):
    # A fixed gain reads its first parameter only; OGBench writes others as well.
    ours, theirs = (model.actuator_gainprm[:, 0] for model in models)
    np.testing.assert_array_equal(ours, theirs)
    np.testing.assert_array_equal(ours[:6], [4500, 4500, 4500, 2000, 2000, 500])


def test_equality_constraints(models):
    for field in ("eq_type", "eq_solref", "eq_solimp", "eq_active0"):
        ours, theirs = (getattr(model, field) for model in models)
        np.testing.assert_array_equal(ours, theirs)
    # A connect constraint reads two anchors, a joint constraint five coefficients.
    ours, theirs = (model.eq_data[:, :6] for model in models)
    np.testing.assert_allclose(ours, theirs, atol=1e-9)


def test_masses_and_inertias(models):
    ours, theirs = models
    for index in range(1, ours.nbody):
        name = ours.body(index).name
        one, other = ours.body(index), theirs.body(BODIES.get(name, GRIPPER + name))
        np.testing.assert_allclose(one.mass, other.mass, rtol=1e-9, err_msg=name)
        np.testing.assert_allclose(one.inertia, other.inertia, rtol=1e-6, err_msg=name)
    # OGBench's markers of targets are moved by hand and take no part: all the rest is here.
    moving = theirs.body_mocapid < 0
    assert ours.body_mass.sum() == pytest.approx(theirs.body_mass[moving].sum(), rel=1e-9)


def test_smooth_dynamics_at_random_states(models):
    """Inertia matrix, gravity and Coriolis forces, passive and actuator forces, poses of sites."""
    rng = np.random.default_rng(0)
    ours, theirs = models
    for _ in range(20):
        qpos = ours.qpos0.copy()
        qpos[:6] = rng.uniform(-3, 3, 6)
        qpos[6:14] = rng.uniform(-0.8, 0.8, 8)
        qvel, ctrl = rng.normal(size=ours.nv), rng.uniform(-3, 250, 7)
        one, other = forward(ours, qpos, qvel, ctrl), forward(theirs, qpos, qvel, ctrl)
        for field in ("M", "qfrc_bias", "qfrc_passive", "qfrc_actuator", "qacc_smooth"):
            expected = getattr(other, field)
            np.testing.assert_allclose(
                getattr(one, field), expected, atol=1e-8 * np.abs(expected).max(), err_msg=field
            )
        pinch = other.site(GRIPPER + "pinch")
        np.testing.assert_allclose(one.site("pinch").xpos, pinch.xpos, atol=1e-12)
        np.testing.assert_allclose(one.site("pinch").xmat, pinch.xmat, atol=1e-12)


def pose(
    scene: Scene,
    effector: tuple[float, ...] = (0.4, 0.0, 0.3, 0.0),
    fingers: tuple[float, float] = (0.0, 0.0),
    cube_0: tuple[float, ...] = (0.3, -0.2, 0.0199),
    cube_1: tuple[float, ...] = (0.5, 0.2, 0.0199),
) -> np.ndarray:
    """qpos: effector at (x, y, z, yaw), right and left driver's angle, places of upright cubes."""
    qpos = scene.home_qpos.copy()
    x, y, z, yaw = effector
    home = jnp.asarray(qpos[scene.arm])
    qpos[scene.arm] = kinematics.inverse(jnp.array([x, y, z]), jnp.array(yaw, float), near=home)
    driver, coupler, spring_link, follower = 1.0, 0.0, 1.0, -1.0
    qpos[scene.gripper] = np.outer(fingers, [driver, coupler, spring_link, follower]).ravel()
    qpos[14:17], qpos[21:24] = cube_0, cube_1
    return qpos


# What touches -> the pose, and the kinds of pairs that must be seen there.
CONTACTS: dict[str, tuple[dict, set[tuple[str, str]]]] = {
    "floor": ({}, {("floor", "cube_0"), ("floor", "cube_1")}),
    "walls near and left": (
        {"cube_0": (0.236, -0.2, 0.0199), "cube_1": (0.5, 0.37, 0.0199)},
        {("wall_near", "cube_0"), ("wall_left", "cube_1")},
    ),
    "walls far and right": (
        {"cube_0": (0.614, -0.2, 0.0199), "cube_1": (0.5, -0.37, 0.0199)},
        {("wall_far", "cube_0"), ("wall_right", "cube_1")},
    ),
    "stack": ({"cube_0": (0.5, 0.2, 0.0598)}, {("cube_0", "cube_1")}),
    "cubes side by side": ({"cube_0": (0.51, 0.1601, 0.0199)}, {("cube_0", "cube_1")}),
    "shut": (
        {"fingers": (0.75, 0.86)},
        {(f"right_pad_{i}", f"left_pad_{j}") for i, j in ((0, 0), (1, 0), (1, 1))},
    ),
    "grasp": (
        {"effector": (0.4, 0, 0.02, 0), "fingers": (0.45, 0.45), "cube_0": (0.4, 0, 0.0199)},
        {(f"{side}_pad_{i}", "cube_0") for side in ("right", "left") for i in range(2)},
    ),
    "fingers on the floor": (
        {"effector": (0.4, 0, 0.002, 0.3), "fingers": (0.5, 0.5)},
        {("floor", "right_pad_0"), ("floor", "left_pad_0")},
    ),
}


def contacts(
    model: mujoco.MjModel, data: mujoco.MjData, rename: Callable[[str], str | None]
) -> list[tuple]:
    """Contacts between geoms that `rename` knows, sorted: names, place, parameters."""
    rows = []
    for contact in data.contact:
        names = [rename(model.geom(geom).name) for geom in contact.geom]
        if None not in names:
            numbers = [*contact.pos, contact.dist, contact.includemargin, contact.dim]
            # With condim 3, torsional and rolling friction are never read.
            numbers += [*contact.friction[:2], *contact.solref, *contact.solimp]
            rows.append((*names, np.round(numbers, 9)))
    return sorted(rows, key=lambda row: (row[0], row[1], *row[2]))


@pytest.mark.parametrize("where", CONTACTS)
def test_contacts_are_those_mujoco_finds_in_ogbench(scene, models, where):
    arguments, pairs = CONTACTS[where]
    qpos = pose(scene(2), **arguments)
    ours, theirs = models
    found = contacts(ours, forward(ours, qpos), lambda name: name)
    expected = contacts(theirs, forward(theirs, qpos), GEOMS.get)
    assert pairs <= {row[:2] for row in found}
    assert [row[:2] for row in found] == [row[:2] for row in expected]
    np.testing.assert_allclose([row[2] for row in found], [row[2] for row in expected], atol=1e-8)


# Our box of a link of the gripper -> the body whose mesh it stands for, in OGBench.
LINK_BOXES = {"gripper_base_box": GRIPPER + "base"} | {
    f"{side}_{link}_box": f"{GRIPPER}{side}_{link}"
    for side in ("right", "left")
    for link in ("spring_link", "follower")
}


SHALLOW = 0.003  # metres to which contacts of play go in


def depths(model: mujoco.MjModel, data: mujoco.MjData, part_of: Callable) -> dict[str, float]:
    """How deep cube_0 (OGBench's object_0) is in each of the gripper's links, in metres."""
    deepest = dict.fromkeys(LINK_BOXES, 0.0)
    for contact in data.contact:
        geoms = [model.geom(geom) for geom in contact.geom]
        parts = {part_of(geom) for geom in geoms} & set(LINK_BOXES)
        if parts and any(geom.name in ("cube_0", "object_0") for geom in geoms):
            (part,) = parts
            deepest[part] = max(deepest[part], -contact.dist)
    return deepest


def test_links_of_the_gripper_are_where_ogbenchs_meshes_are(scene, models):
    """Of cubes that the open gripper comes down on, or that are beside one of its fingers."""
    ours, theirs = models
    bodies = {name: part for part, name in LINK_BOXES.items()}
    rng = np.random.default_rng(0)
    seen: dict[str, list[float]] = {part: [] for part in LINK_BOXES}
    for _ in range(600):
        angle, side = rng.uniform(0, 0.4), rng.choice([-1, 0, 1])
        around = rng.uniform([-0.004, -0.02, 0.03], [0.004, 0.02, 0.05])
        if side:
            around = rng.uniform([0.06, -0.01, -0.02], [0.1, 0.01, 0.03]) * (side, 1, 1)
        qpos = pose(
            scene(2),
            effector=(0.4, 0, 0.2, np.pi / 2),
            fingers=(angle, angle),
            cube_0=tuple(np.add(around, (0.4, 0, 0.2))),
        )
        one = depths(ours, forward(ours, qpos), lambda geom: geom.name)
        other = depths(
            theirs,
            forward(theirs, qpos),
            lambda geom: bodies.get(theirs.body(geom.bodyid[0]).name),
        )
        for part in LINK_BOXES:
            if 0 < other[part] < SHALLOW:
                seen[part].append(abs(one[part] - other[part]))
    for part, differences in seen.items():
        print(f"{part}: {len(differences)} touched, median {1e3 * np.median(differences):.2f} mm")
        assert len(differences) > 10
        assert np.median(differences) < 2e-4


def test_nothing_collides_outside_the_explicit_pairs(models):
    ours, _ = models
    assert not ours.geom_contype.any()
    assert not ours.geom_conaffinity.any()


def test_acceleration_at_states_of_play(models, play):
    """Contact, linkage and limit forces included."""
    ours, theirs = models
    recording = play(NAME, 1500)
    for row in range(0, 1500, 25):
        state = (recording.qpos[row], recording.qvel[row], recording.ctrl[row])
        one, other = forward(ours, *state), forward(theirs, *state)
        scale = np.abs(other.qacc).max()
        np.testing.assert_allclose(one.qacc, other.qacc, atol=1e-3 * scale, err_msg=f"row {row}")


def replay(scene: Scene, recording, steps: int) -> np.ndarray:
    """Cube position errors (windows * cubes,) in metres after windows of `steps` control steps."""
    physics = MujocoPhysics(scene)
    begin = np.arange(0, len(recording.qpos) - steps, steps)
    ctrl = np.stack([recording.ctrl[begin + step] for step in range(steps)])

    @jax.jit
    def run(qpos, qvel, ctrl):
        states = jax.vmap(physics.init)(qpos, qvel)
        step = jax.vmap(physics.step)
        return jax.lax.scan(lambda states, u: (step(states, u), None), states, ctrl)[0]

    final = run(recording.qpos[begin], recording.qvel[begin], ctrl)
    assert not final.diverged.any()
    error = np.asarray(final.qpos, float) - recording.qpos[begin + steps]
    cubes = error[:, scene.cubes_qpos].reshape(-1, 7)[:, :3]
    return np.linalg.norm(cubes, axis=-1)


@pytest.mark.parametrize("steps", [10, 50])
@pytest.mark.parametrize(("profile", "bound"), [("exact", 1e-5), ("fast", 1e-3)])
def test_replays_play_of_ogbench(scene, play, profile, bound, steps):
    recording = play(NAME, 1500)
    # The stretch is worth replaying: cubes are grasped, carried and stacked in it.
    assert (recording.contact > 0.5).mean() > 0.1
    assert recording.stacked.any()
    errors = replay(scene(2, profile), recording, steps)
    print(f"{profile}, {steps} steps: 95th percentile {np.percentile(errors, 95):.2e} m")
    assert np.percentile(errors, 95) <= bound


def test_a_control_step_is_fifty_milliseconds(models, ogbench_env):
    assert ogbench_env(NAME)._n_steps == SUBSTEPS
    assert SUBSTEPS * models[0].opt.timestep == pytest.approx(0.05)
