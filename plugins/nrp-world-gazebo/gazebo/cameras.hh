// Images by Gazebo's own renderer. It belongs to Gazebo's main thread, which draws while that of the physics waits.
#pragma once

#include <gazebo/common/common.hh>
#include <gazebo/rendering/rendering.hh>

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>

#include "bodies.hh"

namespace nrp
{
class Cameras
{
public:
  /// \param images the name of the file that holds the images and is shared with the engine in Python
  Cameras(const gazebo::physics::WorldPtr &world, const std::string &images);
  ~Cameras();
  Cameras(const Cameras &) = delete;
  Cameras &operator=(const Cameras &) = delete;

  /// Add a camera that a link carries; its images are at an offset in the file.
  void Add(const Bodies &bodies, Reader &request);

  /// Draw the image of a camera.
  void Draw(const Bodies &bodies, std::uint32_t number);

  /// Set the colour of a visual, and whether it glows, from the next image on.
  void Paint(Reader &request);

  /// Set colour, place, direction and attenuation of a light from the next image on.
  void Light(Reader &request);

private:
  struct Eye
  {
    gazebo::physics::LinkPtr link;
    Pose3d held;           ///< the camera's pose in the frame of its link
    std::uint32_t width, height, offset;
    double fov, near, far;
    gazebo::rendering::CameraPtr camera;
  };

  /// Have something done by the main thread and wait for it.
  void InMainThread(const std::function<void()> &work);
  void OnRender();
  bool HasAllVisuals();
  void Open(Eye &eye, std::size_t number);
  void Show(const Bodies &bodies);

  gazebo::physics::WorldPtr world_;
  gazebo::rendering::ScenePtr scene_;
  gazebo::event::ConnectionPtr render_;
  char *images_ = nullptr;
  std::size_t size_ = 0;
  std::vector<Eye> eyes_;
  std::mutex mutex_;
  std::condition_variable done_;
  std::function<void()> work_;
  std::exception_ptr failure_;
};
}  // namespace nrp
