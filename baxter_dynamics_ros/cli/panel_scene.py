"""The robot in 3D: the manufacturer's meshes if installed, otherwise capsules along the links."""

from functools import lru_cache
from pathlib import Path
import sys
from typing import Any

import numpy as np
import trimesh
import viser
from viser.transforms import SO3
import yourdfpy  # type: ignore[import-untyped]

from ..model.arm import BaxterArm
from ..model.arrays import Array
from ..model.joints import joint_names, JOINTS, mount, SIDES
from ..model.lagrange_euler import transform

_IN_WHEEL = Path('cmeel.prefix', 'share', 'example-robot-data', 'robots', 'baxter_description')
_TOUCHED = (255, 140, 0)
_FORCE = (200, 30, 20)
_PLAIN = (120, 128, 136)
_CELL = 0.006  # [m]; the manufacturer's 400,000 triangles are slow to load and to draw
_RADIUS = 0.05  # of a capsule [m]
_METRES_PER_NEWTON = 0.015
_LONGEST = 0.6  # of the arrow [m]
_SMALLEST = 1.0  # force that is drawn [N]

Color = tuple[int, int, int]


class Scene:
    """Both arms and the external force at the hand of one of them."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = server.scene
        self._arms = {side: BaxterArm(mount=mount(side)) for side in SIDES}
        self._joints: dict[str, tuple[viser.FrameHandle, Array]] = {}  # with its fixed pose
        self._meshes: dict[str, list[tuple[viser.MeshHandle, Color]]] = {}  # by joint
        self._touched: set[str] = set()
        self._scene.set_up_direction('+z')
        self._scene.add_grid('/floor', width=4.0, height=4.0, position=(0.0, 0.0, -0.92),
                             cell_color=(220, 224, 228), section_color=(196, 202, 208))
        self._arrow = self._scene.add_arrows(
            '/force', np.zeros((1, 2, 3)), _FORCE, shaft_radius=0.012, head_radius=0.03,
            head_length=0.06, visible=False)
        self._label = self._scene.add_label('/newtons', '', visible=False)
        server.initial_camera.position = (1.7, -1.15, 0.5)
        server.initial_camera.look_at = (0.25, 0.0, -0.05)
        description = find_meshes()
        if description:
            self._add_meshes(description)
        else:
            self._add_capsules()

    def move(self, positions: dict[str, float]) -> None:
        """Move joints to positions by name [rad]."""
        for name in positions.keys() & self._joints.keys():
            frame, pose = self._joints[name]
            frame.wxyz = SO3.from_matrix(pose[:3, :3]).multiply(
                SO3.from_z_radians(positions[name])).wxyz
        if not self._joints:
            self._move_capsules(positions)

    def touch(self, names: set[str]) -> None:
        """Colour the links behind joints that are in contact."""
        for name in names ^ self._touched:
            for mesh, color in self._meshes.get(name, ()):
                mesh.color = _TOUCHED if name in names else color
        self._touched = names

    def push(self, side: str, q: Array, force: Array | None, in_hand: bool) -> None:
        """Draw a force (3,) [N], if any, at the hand, in axes of the hand or of the base."""
        size = 0.0 if force is None else float(np.linalg.norm(force))
        self._arrow.visible = self._label.visible = size > _SMALLEST
        if force is not None and size > _SMALLEST:
            hand = self._arms[side].forward_kinematics(q)
            axis = (hand[:3, :3] @ force if in_hand else force) / size
            length, start = min(_METRES_PER_NEWTON * size, _LONGEST), hand[:3, 3]
            self._arrow.points = np.array([[start, start + length * axis]])
            self._label.position = start + (0.05 + length) * axis
            self._label.text = f'{size:.0f} N'

    def _add_meshes(self, folder: Path) -> None:
        urdf = yourdfpy.URDF.load(str(folder / 'urdf' / 'baxter.urdf'), load_meshes=False,
                                  build_scene_graph=False)
        children = {joint.child for joint in urdf.joint_map.values()}
        root = next(link for link in urdf.link_map if link not in children)
        arms = [name for side in SIDES for name in joint_names(side)]
        places = [(root, '/robot', '')]  # link, its path, the arm's joint before it
        for link, path, moved_by in places:
            for visual in urdf.link_map[link].visuals:
                if visual.geometry.mesh is not None and 'gripper' not in link:
                    file = folder / visual.geometry.mesh.filename.split('baxter_description/')[-1]
                    self._add_mesh(f'{path}/mesh', file, visual.origin, moved_by)
            for joint in (each for each in urdf.joint_map.values() if each.parent == link):
                pose = np.eye(4) if joint.origin is None else joint.origin
                frame = self._scene.add_frame(
                    f'{path}/{joint.child}', show_axes=False, position=pose[:3, 3],
                    wxyz=SO3.from_matrix(pose[:3, :3]).wxyz)
                name = joint.name if joint.name in arms else moved_by
                if joint.name in arms:
                    self._joints[joint.name] = frame, pose
                places.append((joint.child, f'{path}/{joint.child}', name))

    def _add_mesh(self, path: str, file: Path, origin: Array | None, joint: str) -> None:
        pose = np.eye(4) if origin is None else origin
        for i, (vertices, faces, color) in enumerate(_load(file)):
            mesh = self._scene.add_mesh_simple(
                f'{path}{i}', vertices @ pose[:3, :3].T + pose[:3, 3], faces, color=color)
            self._meshes.setdefault(joint, []).append((mesh, color))

    def _add_capsules(self) -> None:
        for side, arm in self._arms.items():
            for name, length in zip(joint_names(side), _lengths(arm)):
                shape = trimesh.creation.capsule(length, _RADIUS)
                mesh = self._scene.add_mesh_simple(f'/capsules/{name}', shape.vertices,
                                                   shape.faces, color=_PLAIN)
                self._meshes[name] = [(mesh, _PLAIN)]

    def _move_capsules(self, positions: dict[str, float]) -> None:
        for side, arm in self._arms.items():
            names = joint_names(side)
            if positions.keys() >= set(names):
                points = _origins(arm, np.array([positions[name] for name in names]))
                for name, start, end in zip(names, points, points[1:]):
                    (mesh, _), = self._meshes[name]
                    mesh.position = start
                    mesh.wxyz = _towards(end - start)


def find_meshes() -> Path | None:
    """Return the folder of the manufacturer's description with meshes; None if not installed."""
    return next((path for folder in sys.path
                 if (path := Path(folder) / _IN_WHEEL).is_dir()), None)


@lru_cache
def _load(file: Path) -> list[tuple[Array, Array, Color]]:
    """Return vertices, faces and colour of each part of a mesh."""
    loaded = []
    scene: Any = trimesh.load_scene(file)
    for part in scene.dump():
        red, green, blue, _ = getattr(part.visual, 'material', part.visual).main_color.tolist()
        loaded.append((*_coarse(part), (red, green, blue)))
    return loaded


def _coarse(mesh: trimesh.Trimesh) -> tuple[Array, Array]:
    """Return vertices and faces with vertices in the same cell merged, a quarter or less."""
    cells = np.round(mesh.vertices / _CELL).astype(int)
    _, first, index = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    faces = index.ravel()[mesh.faces]
    keep = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
    return mesh.vertices[first], np.unique(faces[keep], axis=0)


def _origins(arm: BaxterArm, q: Array) -> Array:
    """Return the origins of the link frames 0 to 7 in the base frame, (8, 3) [m]."""
    return np.array([(arm.mount @ transform(arm.parameters, 0, j, q))[:3, 3]
                     for j in range(len(JOINTS) + 1)])


def _lengths(arm: BaxterArm) -> Array:
    return np.linalg.norm(np.diff(_origins(arm, np.zeros(len(JOINTS))), axis=0), axis=1)


def _towards(direction: Array) -> Array:
    """Return the quaternion (4,) that turns the z axis into a direction (3,)."""
    length = np.linalg.norm(direction)
    if length < 1e-9:
        return np.array([1.0, 0.0, 0.0, 0.0])
    x, y, z = direction / length
    if z < -1.0 + 1e-9:
        return np.array([0.0, 1.0, 0.0, 0.0])
    quaternion = np.array([1.0 + z, -y, x, 0.0])
    return quaternion / np.linalg.norm(quaternion)
