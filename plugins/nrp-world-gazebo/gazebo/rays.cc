#include "rays.hh"

#include <gazebo/ode/ode.h>
#include <gazebo/physics/ode/ODECollision.hh>
#include <gazebo/physics/ode/ODEPhysics.hh>

#include <algorithm>
#include <limits>
#include <set>

namespace nrp
{
namespace
{
/// The nearest shape along one ray.
struct Search
{
  dGeomID ray;
  std::set<const gazebo::physics::Link *> ignored;
  double nearest = 0;
};

const gazebo::physics::Link *LinkOf(dGeomID shape)
{
  const dGeomID inner = dGeomGetClass(shape) == dGeomTransformClass ? dGeomTransformGetGeom(shape) : shape;
  const auto *collision = static_cast<gazebo::physics::ODECollision *>(dGeomGetData(inner));
  return collision ? collision->GetLink().get() : nullptr;
}

void Meet(void *data, dGeomID one, dGeomID other)
{
  if (dGeomIsSpace(one) || dGeomIsSpace(other))
    return dSpaceCollide2(one, other, data, &Meet);
  Search &search = *static_cast<Search *>(data);
  const dGeomID shape = one == search.ray ? other : one;
  if (dGeomGetClass(shape) == dRayClass || search.ignored.count(LinkOf(shape)))
    return;
  dContactGeom met;
  if (dCollide(search.ray, shape, 1, &met, sizeof(met)))
    search.nearest = std::min(search.nearest, static_cast<double>(met.depth));
}
}  // namespace

void AddScan(const gazebo::physics::WorldPtr &world, const Bodies &bodies, Reader &request, Writer &answer)
{
  const auto ode = boost::dynamic_pointer_cast<gazebo::physics::ODEPhysics>(world->Physics());
  if (!ode)
    throw std::runtime_error("rays need the physics engine 'ode'");
  Search search;
  for (auto count = request.Next<std::uint32_t>(); count > 0; --count)
    search.ignored.insert(bodies.Link(request.Next<std::uint32_t>()).get());
  const auto count = request.Next<std::uint32_t>();
  const auto eye = request.Doubles(3), reach = request.Doubles(2), rays = request.Doubles(3 * std::size_t{count});
  const double length = reach[1] - reach[0], none = std::numeric_limits<double>::infinity();
  search.ray = dCreateRay(nullptr, length);
  dGeomRaySetClosestHit(search.ray, 1);
  for (auto ray = rays.begin(); ray != rays.end(); ray += 3)
  {
    search.nearest = none;
    dGeomRaySet(search.ray, eye[0] + reach[0] * ray[0], eye[1] + reach[0] * ray[1], eye[2] + reach[0] * ray[2],
                ray[0], ray[1], ray[2]);
    dSpaceCollide2(search.ray, reinterpret_cast<dGeomID>(ode->GetSpaceId()), &search, &Meet);
    answer.Add(reach[0] + search.nearest);
  }
  dGeomDestroy(search.ray);
}
}  // namespace nrp
