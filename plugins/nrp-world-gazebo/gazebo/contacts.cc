#include "contacts.hh"

namespace nrp
{
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
