"""Small models that are built with OpenSim and written to files."""

from pathlib import Path
from typing import Any

import opensim as osim

osim.Logger.removeFileSink()  # no opensim.log in the working folder
opensim_axis = osim.CoordinateAxis.getCoordinateAxis
QUARTER = 1.5707963267948966


def arm(elbow: float = 0.6) -> Any:
    """A shoulder and an elbow, and two muscles at the elbow, one of which wraps around it."""
    model = osim.Model()
    model.setName("arm")
    upper = osim.Body("upper_arm", 0.8, osim.Vec3(0.15, 0, 0), osim.Inertia(5e-4, 6e-3, 6e-3, 0, 0, 0))
    fore = osim.Body("forearm", 0.5, osim.Vec3(0.15, 0, 0), osim.Inertia(3e-4, 4e-3, 4e-3, 0, 0, 0))
    upper.attachGeometry(osim.Brick(osim.Vec3(0.15, 0.02, 0.03)))
    fore.attachGeometry(osim.Cylinder(0.02, 0.15))
    hand = osim.PhysicalOffsetFrame("hand", fore, osim.Transform(osim.Vec3(0.3, 0, 0)))
    fore.addComponent(hand)
    hand.attachGeometry(osim.Sphere(0.03))
    for body in (upper, fore):
        model.addBody(body)
    ground = model.getGround()
    add_pin(model, "shoulder", ground, (0, 1, 0), upper, -0.5)
    add_pin(model, "elbow", upper, (0.3, 0, 0), fore, elbow)
    wrap = osim.WrapCylinder()
    wrap.setName("capsule")
    wrap.set_radius(0.03)
    wrap.set_length(0.1)
    wrap.set_translation(osim.Vec3(0.3, 0, 0))
    upper.addWrapObject(wrap)
    ends = {"flexor": ((0.05, 0.03, 0), (0.05, 0.02, 0)), "extensor": ((0.02, -0.03, 0), (-0.02, -0.03, 0))}
    for name, (origin, insertion) in ends.items():
        slack = 0.2 if name == "extensor" else 0.16
        pulls = osim.Millard2012EquilibriumMuscle(name, 600, 0.12, slack, 0.1)
        pulls.addNewPathPoint("origin", upper, osim.Vec3(*origin))
        pulls.addNewPathPoint("insertion", fore, osim.Vec3(*insertion))
        if name == "extensor":
            pulls.updGeometryPath().addPathWrap(wrap)
        model.addForce(pulls)
    return model


def add_pin(model: Any, name: str, parent: Any, place: Any, child: Any, start: float) -> None:
    """Hold a body by a hinge about z."""
    zero = osim.Vec3(0)
    joint = osim.PinJoint(f"{name}_joint", parent, osim.Vec3(*place), zero, child, zero, zero)
    coordinate = joint.updCoordinate()
    coordinate.setName(name)
    coordinate.setDefaultValue(start)
    coordinate.setRangeMin(-2)
    coordinate.setRangeMax(2.5)
    model.addJoint(joint)


def ball() -> Any:
    """A ball that falls on the ground, with a free joint and the contact of Hunt and Crossley."""
    model = osim.Model()
    model.setName("ball")
    body = osim.Body("ball", 1.0, osim.Vec3(0), osim.Inertia(0.004, 0.004, 0.004, 0, 0, 0))
    model.addBody(body)
    joint = osim.FreeJoint("free", model.getGround(), body)
    joint.updCoordinate(osim.FreeJoint.Coord_TranslationY).setDefaultValue(0.12)
    joint.updCoordinate(osim.FreeJoint.Coord_TranslationX).setDefaultSpeedValue(0.5)
    joint.updCoordinate(osim.FreeJoint.Coord_Rotation2Y).setDefaultValue(0.3)
    model.addJoint(joint)
    floor = osim.ContactHalfSpace(osim.Vec3(0), osim.Vec3(0, 0, -QUARTER), model.getGround(), "floor")
    sphere = osim.ContactSphere(0.1, osim.Vec3(0), body, "sphere")
    model.addContactGeometry(floor)
    model.addContactGeometry(sphere)
    touch = osim.HuntCrossleyForce()
    touch.setName("touch")
    touch.addGeometry("floor")
    touch.addGeometry("sphere")
    touch.setStiffness(1e6)
    touch.setDissipation(0.5)
    touch.setStaticFriction(0.8)
    touch.setDynamicFriction(0.4)
    model.addForce(touch)
    return model


def knee() -> Any:
    """A custom joint that slides as it turns, a coordinate that follows it, a locked one, and two motors."""
    model = osim.Model()
    model.setName("knee")
    names = ("thigh", "shank", "patella", "toes")
    bodies = {
        name: osim.Body(name, 1.0, osim.Vec3(0, -0.1, 0), osim.Inertia(0.01, 0.002, 0.01, 0, 0, 0))
        for name in names
    }
    for body in bodies.values():
        model.addBody(body)
    add_pin(model, "hip", model.getGround(), (0, 1, 0), bodies["thigh"], 0.3)
    transform = osim.SpatialTransform()
    angle = osim.ArrayStr()
    angle.append("knee_angle")
    turning = transform.updTransformAxis(2)
    turning.setCoordinateNames(angle)
    turning.set_function(osim.LinearFunction(1.0, 0.0))
    slide = osim.SimmSpline()
    for x, y in ((-2.0, -0.01), (-1.0, 0.0), (0.0, 0.004), (1.0, 0.002), (2.0, -0.004)):
        slide.addPoint(x, y)
    sliding = transform.updTransformAxis(3)
    sliding.setCoordinateNames(angle)
    sliding.set_function(slide)
    zero = osim.Vec3(0)
    at = osim.Vec3(0, -0.4, 0)
    joint = osim.CustomJoint("knee", bodies["thigh"], at, zero, bodies["shank"], zero, zero, transform)
    coordinate = osim.Coordinate("knee_angle", osim.Coordinate.Rotational, -0.4, -2.0, 2.0)
    joint.append_coordinates(coordinate)
    model.addJoint(joint)
    planar = osim.PlanarJoint(
        "patella", bodies["thigh"], osim.Vec3(0.05, -0.35, 0), zero, bodies["patella"], zero, zero
    )
    for index, (name, start) in enumerate((("patella_rz", 0.1), ("patella_tx", 0.01), ("patella_ty", 0.02))):
        coordinate = planar.updCoordinate(index)
        coordinate.setName(name)
        coordinate.setDefaultValue(start)
        coordinate.set_locked(index == 1)
    model.addJoint(planar)
    model.addJoint(osim.WeldJoint("toes", bodies["shank"], at, zero, bodies["toes"], zero, zero))
    follows = osim.CoordinateCouplerConstraint()
    follows.setName("follows")
    follows.setIndependentCoordinateNames(angle)
    follows.setDependentCoordinateName("patella_rz")
    follows.setFunction(osim.LinearFunction(0.5, 0.3))
    model.addConstraint(follows)
    motor = osim.CoordinateActuator("hip")
    motor.setName("hip_motor")
    motor.setOptimalForce(20.0)
    motor.setMinControl(-1.0)
    motor.setMaxControl(1.0)
    model.addForce(motor)
    stop = osim.CoordinateLimitForce("knee_angle", 0.0, 20.0, -120.0, 20.0, 1.0, 5.0)
    stop.setName("stop")
    model.addForce(stop)
    return model


def written(model: Any, folder: Path) -> Path:
    """Return the file of a model."""
    model.finalizeConnections()
    path = folder / f"{model.getName()}.osim"
    model.printToXML(str(path))
    return path


MODELS = {"arm": arm, "ball": ball, "knee": knee}
