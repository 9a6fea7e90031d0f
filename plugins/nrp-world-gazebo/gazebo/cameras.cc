#include "cameras.hh"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <sstream>
#include <utility>

namespace nrp
{
Cameras::Cameras(const gazebo::physics::WorldPtr &world, const std::string &images) : world_(world)
{
  const int file = ::open(images.c_str(), O_RDWR);
  struct stat about{};
  if (file < 0 || ::fstat(file, &about) != 0)
    throw std::runtime_error("cannot open " + images);
  size_ = static_cast<std::size_t>(about.st_size);
  void *const memory = ::mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  ::close(file);
  if (memory == MAP_FAILED)
    throw std::runtime_error("cannot share the memory of " + images);
  images_ = static_cast<char *>(memory);
  world_->SetPaused(true);  // no step is taken until the renderer has all visuals
  render_ = gazebo::event::Events::ConnectRender(std::bind(&Cameras::OnRender, this));
}

Cameras::~Cameras()
{
  ::munmap(images_, size_);
}

void Cameras::Add(const Bodies &bodies, Reader &request)
{
  Eye eye;
  eye.link = bodies.Link(request.Next<std::uint32_t>());
  eye.width = request.Next<std::uint32_t>();
  eye.height = request.Next<std::uint32_t>();
  eye.offset = request.Next<std::uint32_t>();
  const auto h = request.Doubles(7), optics = request.Doubles(3);
  eye.held = Pose3d(h[0], h[1], h[2], h[6], h[3], h[4], h[5]);
  eye.fov = optics[0];
  eye.near = optics[1];
  eye.far = optics[2];
  if (eye.offset + std::size_t{3} * eye.width * eye.height > size_)
    throw std::runtime_error("the file of images is too small");
  eyes_.push_back(eye);
}

void Cameras::Draw(const Bodies &bodies, std::uint32_t number)
{
  Eye &eye = eyes_.at(number);
  InMainThread([&] {
    if (!eye.camera)
      Open(eye, number);
    Show(bodies);
    eye.camera->SetWorldPose(eye.held + eye.link->WorldPose());
    eye.camera->Render(true);
    eye.camera->PostRender();
    const unsigned char *data = eye.camera->ImageData();
    if (!data)
      throw std::runtime_error("Gazebo's renderer drew no image");
    std::memcpy(images_ + eye.offset, data, std::size_t{3} * eye.width * eye.height);
  });
}

void Cameras::Paint(Reader &request)
{
  const std::string name = request.Text();
  const auto c = request.Doubles(5);
  InMainThread([&] {
    const auto visual = scene_->GetVisual(name);
    if (!visual)
      throw std::runtime_error("Gazebo's renderer has no visual " + name);
    const ignition::math::Color color(c[0], c[1], c[2]);
    visual->SetAmbient(color);
    visual->SetDiffuse(color);
    visual->SetEmissive(c[4] > 0 ? color : ignition::math::Color::Black);
    visual->SetTransparency(c[3] > 0 ? 0 : 1);
  });
}

void Cameras::Light(Reader &request)
{
  const std::string name = request.Text();
  const auto l = request.Doubles(13);
  InMainThread([&] {
    const auto light = scene_->LightByName(name);
    if (!light)
      throw std::runtime_error("Gazebo's renderer has no light " + name);
    light->SetDiffuseColor(ignition::math::Color(l[0], l[1], l[2]));
    light->SetPosition(Vector3d(l[3], l[4], l[5]));
    light->SetDirection(Vector3d(l[6], l[7], l[8]));
    light->SetRange(l[9]);
    light->SetAttenuation(l[10], l[11], l[12]);
  });
}

void Cameras::InMainThread(const std::function<void()> &work)
{
  std::unique_lock<std::mutex> lock(mutex_);
  work_ = work;
  done_.wait(lock, [this] { return !work_; });
  if (failure_)
    std::rethrow_exception(std::exchange(failure_, nullptr));
}

void Cameras::OnRender()
{
  if (!scene_ && HasAllVisuals())
  {
    scene_ = gazebo::rendering::get_scene(world_->Name());
    world_->SetPaused(false);
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!work_)
    return;
  try
  {
    work_();
  }
  catch (...)
  {
    failure_ = std::current_exception();
  }
  work_ = nullptr;
  done_.notify_one();
}

bool Cameras::HasAllVisuals()
{
  const auto scene = gazebo::rendering::get_scene(world_->Name());
  if (!scene || !scene->Initialized())
    return false;
  const auto models = world_->Models();
  return std::all_of(models.begin(), models.end(), [&](const auto &model) {
    const auto links = model->GetLinks();
    return std::all_of(links.begin(), links.end(),
                       [&](const auto &link) { return scene->GetVisual(link->GetScopedName()); });
  });
}

void Cameras::Open(Eye &eye, std::size_t number)
{
  const std::string name = "nrp_camera_" + std::to_string(number);
  std::ostringstream text;
  text.precision(17);
  text << "<sdf version='1.6'><camera name='" << name << "'><horizontal_fov>" << eye.fov
       << "</horizontal_fov><image><width>" << eye.width << "</width><height>" << eye.height
       << "</height><format>R8G8B8</format></image><clip><near>" << eye.near << "</near><far>" << eye.far
       << "</far></clip></camera></sdf>";
  const auto sdf = std::make_shared<sdf::Element>();
  sdf::initFile("camera.sdf", sdf);
  sdf::readString(text.str(), sdf);
  eye.camera = scene_->CreateCamera(name, false);
  if (!eye.camera)
    throw std::runtime_error("Gazebo's renderer made no camera");
  eye.camera->SetCaptureData(true);
  eye.camera->Load(sdf);
  eye.camera->Init();
  eye.camera->CreateRenderTexture(name + "_texture");
}

/// Show all bodies where the physics has them; messages about it come later.
void Cameras::Show(const Bodies &bodies)
{
  for (std::uint32_t number = 0; number < bodies.Movable(); ++number)
  {
    const auto &link = bodies.Link(number);
    if (const auto visual = scene_->GetVisual(link->GetScopedName()))
      visual->SetWorldPose(link->WorldPose());
  }
}
}  // namespace nrp
