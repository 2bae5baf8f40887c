"""Views of the panel: the robot in 3D, and charts of the last 30 s."""

from collections import deque
from functools import lru_cache
import math
from pathlib import Path
import sys
from typing import Any

from geometry_msgs.msg import WrenchStamped
import numpy as np
import trimesh
from trimesh.geometry import align_vectors
import viser
from viser import uplot
from viser.transforms import SO3
import yourdfpy  # type: ignore[import-untyped]

from ..model import Array, BaxterArm, joint_names, JOINTS, mount, SIDES
from ..model.lagrange_euler import link_transform

Color = tuple[int, int, int]

_ARM_JOINTS = [name for side in SIDES for name in joint_names(side)]
_IN_WHEEL = Path('cmeel.prefix', 'share', 'example-robot-data', 'robots', 'baxter_description')
_TOUCHED, _FORCE, _PLAIN = (255, 140, 0), (200, 30, 20), (120, 128, 136)
_RADIUS = 0.05  # of a capsule [m]
_CELL = 0.006  # [m]; the manufacturer's 400,000 triangles are slow to load and to draw
_METRES_PER_NEWTON = 0.015
_LONGEST = 0.6  # of the arrow [m]
_SMALLEST = 1.0  # force that is drawn [N]

_WINDOW = 30.0  # of the charts [s]
_LOWEST = 0.2  # height of a scale [N m]
_GRAY, _BLUE, _RED = '#8a949e', '#1f77c9', '#d1402b'
_CLEAR, _SHADE = 'rgba(0, 0, 0, 0)', 'rgba(31, 119, 201, 0.16)'


class Scene:
    """The manufacturer's robot, or capsules along its links, and the force at one hand."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._scene = server.scene
        self._arms = {side: BaxterArm(mount=mount(side)) for side in SIDES}
        self._joints: dict[str, tuple[viser.FrameHandle, SO3]] = {}  # and rotation at 0 rad
        self._meshes: dict[str, list[tuple[viser.MeshHandle, Color]]] = {}  # by joint
        self._scene.set_up_direction('+z')
        self._scene.add_grid('/floor', width=4.0, height=4.0, position=(0.0, 0.0, -0.92),
                             cell_color=(220, 224, 228), section_color=(196, 202, 208))
        self._arrow = self._scene.add_arrows(
            '/force', np.zeros((1, 2, 3)), _FORCE, shaft_radius=0.012, head_radius=0.03,
            head_length=0.06, visible=False)
        self._label = self._scene.add_label('/newtons', '', visible=False)
        server.initial_camera.position = (1.7, -1.15, 0.5)
        server.initial_camera.look_at = (0.25, 0.0, -0.05)
        folders = [path for each in sys.path if (path := Path(each) / _IN_WHEEL).is_dir()]
        if folders:
            urdf = yourdfpy.URDF.load(str(folders[0] / 'urdf' / 'baxter.urdf'), load_meshes=False,
                                      build_scene_graph=False)
            self._add_link(urdf, folders[0], 'base', '/robot', '')
        else:
            self._add_capsules()

    def move(self, positions: dict[str, float]) -> None:
        """Move joints to positions by name [rad]."""
        for name in positions.keys() & self._joints.keys():
            frame, rotation = self._joints[name]
            frame.wxyz = rotation.multiply(SO3.from_z_radians(positions[name])).wxyz

    def touch(self, names: set[str]) -> None:
        """Colour the links behind joints that are in contact."""
        for name, meshes in self._meshes.items():
            for mesh, color in meshes:
                mesh.color = _TOUCHED if name in names else color

    def push(self, side: str, q: Array, wrench: WrenchStamped | None) -> None:
        """Draw a force, if any, at the hand; its axes are the base's or the hand's."""
        force = np.zeros(3) if wrench is None else force_of(wrench)
        size = float(np.linalg.norm(force))
        self._arrow.visible = self._label.visible = size > _SMALLEST
        if wrench is not None and size > _SMALLEST:
            hand = self._arms[side].forward_kinematics(q)
            in_hand = wrench.header.frame_id.endswith('_hand')
            axis = (hand[:3, :3] @ force if in_hand else force) / size
            length, start = min(_METRES_PER_NEWTON * size, _LONGEST), hand[:3, 3]
            self._arrow.points = np.array([[start, start + length * axis]])
            self._label.position = start + (0.05 + length) * axis
            self._label.text = f'{size:.0f} N'

    def _add_link(self, urdf: Any, folder: Path, link: str, path: str, moved_by: str) -> None:
        """Add a link at a path of the scene, moved by a joint of an arm, and all behind it."""
        for visual in urdf.link_map[link].visuals:
            if visual.geometry.mesh is not None and 'gripper' not in link:
                file = folder / visual.geometry.mesh.filename.split('baxter_description/')[-1]
                pose = np.eye(4) if visual.origin is None else visual.origin
                for i, (vertices, faces, color) in enumerate(_load(file)):
                    self._add_mesh(f'{path}/mesh{i}', vertices @ pose[:3, :3].T + pose[:3, 3],
                                   faces, color, moved_by)
        for joint in (each for each in urdf.joint_map.values() if each.parent == link):
            below, name = f'{path}/{joint.child}', joint.name if joint.name in _ARM_JOINTS else ''
            self._add_frame(below, np.eye(4) if joint.origin is None else joint.origin, name)
            self._add_link(urdf, folder, joint.child, below, name or moved_by)

    def _add_frame(self, path: str, pose: Array, joint: str) -> None:
        """Add a frame with a pose (4, 4) in its parent, which a joint of an arm may turn."""
        rotation = SO3.from_matrix(pose[:3, :3])
        frame = self._scene.add_frame(path, show_axes=False, position=pose[:3, 3],
                                      wxyz=rotation.wxyz)
        if joint:
            self._joints[joint] = frame, rotation

    def _add_mesh(self, path: str, vertices: Array, faces: Array, color: Color,
                  moved_by: str) -> None:
        mesh = self._scene.add_mesh_simple(path, vertices, faces, color=color)
        self._meshes.setdefault(moved_by, []).append((mesh, color))

    def _add_capsules(self) -> None:
        """Add a capsule along each link of the arms, for want of meshes."""
        for side, arm in self._arms.items():
            path, pose = '/robot', arm.mount
            for i, joint in enumerate(joint_names(side)):
                path += f'/{joint}'
                self._add_frame(path, pose, joint)
                pose = link_transform(arm.parameters, i, np.zeros(len(JOINTS)))
                end = pose[:3, 3]  # origin of the next frame, behind this joint
                turn = align_vectors((0.0, 0.0, 1.0), end)  # type: ignore[no-untyped-call]
                shape = trimesh.creation.capsule(np.linalg.norm(end), _RADIUS, transform=turn)
                # Centred here, because the origin of capsules depends on the version of trimesh.
                center = shape.bounds.mean(axis=0) - end / 2.0
                self._add_mesh(f'{path}/capsule', shape.vertices - center, shape.faces, _PLAIN,
                               joint)


def force_of(wrench: WrenchStamped) -> Array:
    """Return the force of a wrench (3,) [N]."""
    vector = wrench.wrench.force
    return np.array([vector.x, vector.y, vector.z])


@lru_cache
def _load(file: Path) -> list[tuple[Array, Array, Color]]:
    """Return vertices, faces and colour of each part of a mesh, with a quarter of its faces."""
    loaded = []
    scene: Any = trimesh.load_scene(file)
    for part in scene.dump():
        red, green, blue, _ = getattr(part.visual, 'material', part.visual).main_color.tolist()
        cells = np.round(part.vertices / _CELL).astype(int)  # their vertices are merged
        _, first, index = np.unique(cells, axis=0, return_index=True, return_inverse=True)
        faces = index.ravel()[part.faces]
        keep = (faces != np.roll(faces, 1, axis=1)).all(axis=1)
        loaded.append((part.vertices[first], np.unique(faces[keep], axis=0), (red, green, blue)))
    return loaded


class Chart:
    """A chart of some series, with a line of text above it and a scale that changes rarely."""

    def __init__(self, gui: viser.GuiApi, joint: str, colors: tuple[str, ...], bands: Any) -> None:
        is_last = joint == JOINTS[-1]  # with the times below it
        self._joint, self._limits = joint, (0.0, 0.0)
        self._title = gui.add_html('')
        self._handle = gui.add_uplot(
            tuple(np.zeros((1 + len(colors), 1))),
            ({}, *(uplot.Series(stroke=color, width=1.6, points={'show': False})
                   for color in colors)),
            bands=bands, scales={}, legend={'show': False}, cursor={'show': False},
            axes=(_axis(20 if is_last else 8, 60), _axis(44, 18)), height=90 if is_last else 78,
            padding=(6, 12, 0, 0))

    def update(self, text: str, time: Array, columns: Array) -> None:
        """Show a text, and columns (m, n) over time (n,) [s]."""
        self._title.content = (
            '<div style="display:flex;justify-content:space-between;padding:2px 12px 0;'
            f'font-size:13px"><b>{self._joint}</b><span>{text}</span></div>')
        self._handle.data = (time, *columns)
        if not np.isfinite(columns[-1]).any():
            return
        low, high = np.nanmin(columns), np.nanmax(columns)
        if self._handle.bands:  # which are symmetric
            low, high = min(low, -high), max(-low, high)
        limits = steady_range(self._limits, low, high)
        if limits != self._limits:
            self._limits = limits
            self._handle.scales = {'x': {'time': False, 'auto': False, 'range': (-_WINDOW, 0.0)},
                                   'y': {'auto': False, 'range': limits}}


class Charts:
    """Tabs with the residual and the effort of each joint."""

    def __init__(self, gui: viser.GuiApi) -> None:
        self.rows: deque[tuple[float, str, Array]] = deque()
        self.tabs = gui.add_tab_group()
        with self.tabs.add_tab('Residual'):
            gui.add_html(_caption(f'<i style="color:{_RED}">measured − predicted</i> effort in '
                                  'N m; the band holds 95 % of all residuals in free motion'))
            self._residuals = [Chart(gui, joint, (_CLEAR, _CLEAR, _RED), (
                {'series': (1, 2), 'fill': _SHADE},)) for joint in JOINTS]
        with self.tabs.add_tab('Effort'):
            gui.add_html(_caption(f'<i style="color:{_GRAY}">measured</i> and '
                                  f'<i style="color:{_BLUE}">predicted</i> effort in N m'))
            self._efforts = [Chart(gui, joint, (_GRAY, _BLUE), None) for joint in JOINTS]

    def add(self, now: float, name: str, efforts: Array) -> None:
        """Add time now [s], name and efforts (4, 7) of a predictor; drop old and others' rows."""
        self.rows.append((now, name, efforts))
        while self.rows[0][0] < now - _WINDOW or self.rows[0][1] != name:
            self.rows.popleft()

    def update(self, now: float) -> None:
        """Show the rows at monotonic time now [s]."""
        time = np.array([receipt for receipt, *_ in self.rows]) - now
        measured, predicted, residual, band = np.stack([row for *_, row in self.rows], axis=-1)
        for i, (residuals, efforts) in enumerate(zip(self._residuals, self._efforts)):
            efforts.update('', time, np.array([measured[i], predicted[i]]))
            residuals.update(_judged(residual[i, -1], band[i, -1]), time,
                             np.array([band[i], -band[i], residual[i]]))


def steady_range(limits: tuple[float, float], low: float, high: float) -> tuple[float, float]:
    """Return the limits, or wider or narrower ones if values leave them or fill less than 1/4."""
    height = limits[1] - limits[0]
    if limits[0] <= low and high <= limits[1] and (
            4.0 * (high - low) >= height or height <= _LOWEST):
        return limits
    height = max(1.6 * (high - low), _LOWEST)
    step = 10.0 ** math.floor(math.log10(height / 2.0))
    center = (low + high) / 2.0
    return (step * math.floor((center - height / 2.0) / step),
            step * math.ceil((center + height / 2.0) / step))


def _axis(size: int, space: int) -> uplot.Axis:
    stroke = _GRAY if size > 8 else _CLEAR  # no room for numbers
    return uplot.Axis(stroke=stroke, font='11px sans-serif', ticks={'show': False}, size=size,
                      space=space, grid={'stroke': 'rgba(138, 148, 158, 0.22)', 'width': 1})


def _judged(residual: float, band: float) -> str:
    if math.isnan(residual):
        return 'no residual'
    style = f'color:{_RED};font-weight:600' if abs(residual) > band else ''
    expected = '' if math.isnan(band) else f'&ensp;expected ±{band:.2f}'
    return f'<span style="{style}">{residual:+.2f}</span>{expected}'


def _caption(text: str) -> str:
    return f'<div style="padding:8px 12px 0;font-size:12px;opacity:0.75">{text}</div>'
