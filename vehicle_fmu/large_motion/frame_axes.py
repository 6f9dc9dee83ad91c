r"""Motion of a tree of rigid bodies in axes of its frame: twists, momenta and the entries of the mass matrix.

All vectors have components along the axes of the frame, x forward, y right, z down, and all moments are about the point
A of the frame. A link has the twist (omega, v), v the velocity of its point at A. It turns about the axis a through P,
or slides along a, at the rate w, carried by its parent:

    (omega, v) = parent + S w,    S = (a, P x a),  of a slide (0, a)
    (alpha, v') = parent + (omega x a, v x a + omega x (P x a)) w,  of a slide (0, omega x a w)        (without w')

A body of mass m, mass centre c, tensor T about it, and spin momentum i_p W e (of a wheel, whose inertia is the same
about every diameter), under the weight m g, needs the wrench

    F = m (v' + alpha x c + omega x (v + omega x c) - g),    N = c x F + T alpha + omega x (T omega + i_p W e)

and a freedom has the generalised inertia force S.(N, F) of all that it carries. With m, m c and the tensor I about A
of all that the link k carries, the mass matrix is, for a link j on its path,

    M_jk = S_j.(I a + m c x s, m s - m c x a),    S_k = (a, s)

The equations are written for numbers, arrays and symbols (`m`). `vehicle_fmu.large_motion.tree` is a second
formulation, in fixed axes and by Jacobians.

Source: Featherstone, Rigid Body Dynamics Algorithms (2008), recursive Newton-Euler and composite rigid bodies.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

Vector = tuple[Any, Any, Any]
ZERO: Vector = (0, 0, 0)


def dot(a: Vector, b: Vector) -> Any:
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """The vector product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def plus(*vectors: Vector) -> Vector:
    """The sum."""
    x, y, z = (sum(components) for components in zip(*vectors, strict=True))
    return (x, y, z)


def times(factor: Any, a: Vector) -> Vector:
    """The vector with a factor."""
    return (factor * a[0], factor * a[1], factor * a[2])


def once(m: Any, a: Vector) -> Vector:
    """The vector with its components as shared terms."""
    return (m.term(a[0]), m.term(a[1]), m.term(a[2]))


@dataclass(frozen=True)
class Twist:
    """Angular and linear part of a velocity, an acceleration, a wrench (moment, force) or a momentum, at A."""

    angular: Vector
    linear: Vector

    def __add__(self, other: "Twist") -> "Twist":
        return Twist(plus(self.angular, other.angular), plus(self.linear, other.linear))

    def once(self, m: Any) -> "Twist":
        """The same as shared terms."""
        return Twist(once(m, self.angular), once(m, self.linear))

    def times(self, factor: Any) -> "Twist":
        """With a factor."""
        return Twist(times(factor, self.angular), times(factor, self.linear))

    def power(self, wrench: "Twist") -> Any:
        """Its product with a wrench or a momentum."""
        return dot(self.angular, wrench.angular) + dot(self.linear, wrench.linear)

    def velocity(self, point: Vector) -> Vector:
        """The velocity of the body's point there."""
        return plus(self.linear, cross(self.angular, point))


@dataclass(frozen=True)
class Link:
    """A moving link: the directions of its axes, its reference point, the twist of its freedom, its own twist, and its
    acceleration without those of the rates.
    """

    axes: tuple[Vector, Vector, Vector]
    joint: Vector
    freedom: Twist
    twist: Twist
    acceleration: Twist

    def place(self, offset: Vector) -> Vector:
        """The point at an offset along the link's axes from its reference point."""
        return plus(self.joint, *(times(x, axis) for x, axis in zip(offset, self.axes, strict=True)))

    def turned(self, m: Any, about: int, angle: Any, rate: Any, offset: Vector = ZERO, sign: int = 1) -> "Link":
        """The next link: turned about its axis 0, 1 or 2, of that sign, through an offset."""
        axis, joint = times(sign, self.axes[about]), once(m, self.place(offset))
        c, s = m.term(m.cos(angle)), m.term(sign * m.sin(angle))
        second, third = self.axes[(about + 1) % 3], self.axes[(about + 2) % 3]
        turned = list(self.axes)
        turned[(about + 1) % 3] = once(m, plus(times(c, second), times(s, third)))
        turned[(about + 2) % 3] = once(m, plus(times(-s, second), times(c, third)))
        freedom = Twist(axis, once(m, cross(joint, axis)))
        return self._next_link(m, (turned[0], turned[1], turned[2]), joint, freedom, rate)

    def slid(self, m: Any, along: int, distance: Any, rate: Any, sign: int = 1) -> "Link":
        """The next link: slid along its axis 0, 1 or 2, of that sign."""
        axis = times(sign, self.axes[along])
        joint = once(m, plus(self.joint, times(distance, axis)))
        return self._next_link(m, self.axes, joint, Twist(ZERO, axis), rate)

    def _next_link(self, m: Any, axes: tuple[Vector, Vector, Vector], joint: Vector, S: Twist, rate: Any) -> "Link":
        omega, v = self.twist.angular, self.twist.linear
        turning = Twist(cross(omega, S.angular), plus(cross(v, S.angular), cross(omega, S.linear)))
        acceleration = (self.acceleration + turning.times(rate)).once(m)
        return Link(axes, joint, S, (self.twist + S.times(rate)).once(m), acceleration)


@dataclass(frozen=True)
class Inertia:
    """Mass, first moment and tensor (xx, yy, zz, xy, yz, xz) about A of what a link carries."""

    mass: Any
    moment: Vector
    tensor: tuple[Any, ...]

    def __add__(self, other: "Inertia") -> "Inertia":
        tensor = tuple(a + b for a, b in zip(self.tensor, other.tensor, strict=True))
        return Inertia(self.mass + other.mass, plus(self.moment, other.moment), tensor)

    def once(self, m: Any) -> "Inertia":
        """The same as shared terms."""
        return Inertia(m.term(self.mass), once(m, self.moment), tuple(map(m.term, self.tensor)))

    def momentum(self, twist: Twist) -> Twist:
        """Angular and linear momentum at a twist."""
        angular = plus(applied(self.tensor, twist.angular), cross(self.moment, twist.linear))
        linear = plus(times(self.mass, twist.linear), times(-1, cross(self.moment, twist.angular)))
        return Twist(angular, linear)


def applied(tensor: tuple[Any, ...], a: Vector) -> Vector:
    """A symmetric tensor (xx, yy, zz, xy, yz, xz) times a vector."""
    xx, yy, zz, xy, yz, xz = tensor
    return (xx * a[0] + xy * a[1] + xz * a[2], xy * a[0] + yy * a[1] + yz * a[2], xz * a[0] + yz * a[1] + zz * a[2])


@dataclass(frozen=True)
class Solid:
    """A body in axes of its link, with a plane of symmetry y = 0: mass, offset (x, z) of its mass centre from the
    link's reference point, inertias about it, and the integral of x z dm.
    """

    mass: Any
    offset: tuple[Any, Any]
    xx: Any
    yy: Any
    zz: Any
    product: Any

    def joined(self, other: "Solid", m: Any) -> "Solid":
        """Both as one body."""
        mass = m.term(self.mass + other.mass)
        x, z = (
            m.term((self.mass * a + other.mass * b) / mass) for a, b in zip(self.offset, other.offset, strict=True)
        )
        sums = [0, 0, 0, 0]
        for part in (self, other):
            dx, dz = part.offset[0] - x, part.offset[1] - z
            steiner = (dz**2, dx**2 + dz**2, dx**2, dx * dz)
            own = (part.xx, part.yy, part.zz, part.product)
            sums = [s + i + part.mass * d for s, i, d in zip(sums, own, steiner, strict=True)]
        return Solid(mass, (x, z), *map(m.term, sums))


@dataclass(frozen=True)
class Body:
    """A body at a moment: its inertia about A, its mass centre, and its tensor about that."""

    inertia: Inertia
    centre: Vector
    tensor: tuple[Any, ...]

    def wrench(self, link: Link, gravity: Vector, spin: Vector, m: Any) -> Twist:
        """The wrench that its motion without the acceleration of rates and its weight need; spin is its spin
        momentum.
        """
        omega, alpha, c = link.twist.angular, link.acceleration.angular, self.centre
        velocity = once(m, link.twist.velocity(c))
        pull = times(-1, gravity)
        acceleration = plus(link.acceleration.linear, cross(alpha, c), cross(omega, velocity), pull)
        force = once(m, times(self.inertia.mass, acceleration))
        momentum = once(m, plus(applied(self.tensor, omega), spin))
        return Twist(plus(cross(c, force), applied(self.tensor, alpha), cross(omega, momentum)), force).once(m)


def body(solid: Solid, link: Link, m: Any) -> Body:
    """A body of a link."""
    centre = once(m, link.place((solid.offset[0], 0, solid.offset[1])))
    x, _, z = link.axes
    along, up, mixed = solid.xx - solid.yy, solid.zz - solid.yy, -solid.product

    def entry(i: int, k: int) -> Any:
        return along * x[i] * x[k] + up * z[i] * z[k] + mixed * (x[i] * z[k] + z[i] * x[k]) + int(i == k) * solid.yy

    tensor = tuple(m.term(entry(i, k)) for i, k in TENSOR)
    squared = dot(centre, centre)
    steiner = (solid.mass * (int(i == k) * squared - centre[i] * centre[k]) for i, k in TENSOR)
    about = tuple(t + d for t, d in zip(tensor, steiner, strict=True))
    return Body(Inertia(solid.mass, times(solid.mass, centre), about).once(m), centre, tensor)


TENSOR = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def total(inertias: Sequence[Inertia], m: Any) -> Inertia:
    """Inertias of several bodies as one."""
    first, *others = inertias
    return sum(others, first).once(m)
