#include "contacts.hh"

#include <gazebo/physics/ode/ODECollision.hh>
#include <gazebo/physics/ode/ODESurfaceParams.hh>

#include <algorithm>

namespace nrp
{
namespace
{
constexpr double kStiffest = 1e9;   // N/m
constexpr double kSlip = 1e-7;      // m/s for a newton
constexpr double kRemoved = 0.2;    // the share of the depth that a step removes

void Steady(const gazebo::physics::Link &link, double step)
{
  for (const auto &each : link.GetCollisions())
  {
    const auto collision = boost::dynamic_pointer_cast<gazebo::physics::ODECollision>(each);
    if (!collision)
      continue;
    auto &surface = *collision->GetODESurface();
    surface.kp = std::min(surface.kp, kStiffest);
    if (!link.IsStatic())  // ODE adds the damping of both, and a fixed one has none
      surface.kd = std::max(surface.kd, step * surface.kp * (1 / kRemoved - 1));
    surface.slip1 = std::max(surface.slip1, kSlip);
    surface.slip2 = std::max(surface.slip2, kSlip);
  }
}

void SteadyAll(const gazebo::physics::ModelPtr &model, double step)
{
  for (const auto &link : model->GetLinks())
    Steady(*link, step);
  for (const auto &inner : model->NestedModels())
    SteadyAll(inner, step);
}
}  // namespace

void SteadyContacts(const gazebo::physics::WorldPtr &world)
{
  for (const auto &model : world->Models())
    SteadyAll(model, world->Physics()->GetMaxStepSize());
}

void AddContacts(const gazebo::physics::WorldPtr &world, const Bodies &bodies, Writer &answer)
{
  const auto *manager = world->Physics()->GetContactManager();
  std::uint32_t count = 0;
  Writer found;
  for (unsigned int number = 0; number < manager->GetContactCount(); ++number)
  {
    const auto *contact = manager->GetContact(number);
    const auto *one = contact->collision1->GetLink().get(), *other = contact->collision2->GetLink().get();
    if (one->GetModel() == other->GetModel())
      continue;
    for (int point = 0; point < contact->count; ++point)
    {
      const Vector3d &at = contact->positions[point], &normal = contact->normals[point];
      const Vector3d &force = contact->wrench[point].body1Force;
      found.Add(bodies.NumberOf(one));
      found.Add(bodies.NumberOf(other));
      const double row[] = {at.X(), at.Y(), at.Z(), normal.X(), normal.Y(), normal.Z(),
                            contact->depths[point], force.X(), force.Y(), force.Z()};
      found.Add(row, 10);
      ++count;
    }
  }
  answer.Add(count);
  answer.bytes.insert(answer.bytes.end(), found.bytes.begin(), found.bytes.end());
}
}  // namespace nrp
