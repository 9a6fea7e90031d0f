// The frames of the protocol: a length (uint32) and that many bytes, little-endian, over a Unix socket.
#pragma once

#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace nrp
{
/// The version of the protocol; nrp_world_gazebo/wire.py has the same one.
constexpr std::uint32_t kVersion = 3;

/// The other side has ended.
struct Ended : std::runtime_error
{
  using std::runtime_error::runtime_error;
};

/// Reads numbers from a frame, one after the other.
class Reader
{
public:
  Reader() = default;
  explicit Reader(std::vector<char> bytes) : bytes_(std::move(bytes)) {}

  bool AtEnd() const { return place_ == bytes_.size(); }

  template <typename T> T Next()
  {
    T value;
    std::memcpy(&value, Take(sizeof(T)), sizeof(T));
    return value;
  }

  /// The next text: its length, and its bytes.
  std::string Text()
  {
    const auto size = Next<std::uint32_t>();
    return std::string(Take(size), size);
  }

  std::vector<double> Doubles(std::size_t count)
  {
    std::vector<double> values(count);
    if (count)
      std::memcpy(values.data(), Take(count * sizeof(double)), count * sizeof(double));
    return values;
  }

private:
  const char *Take(std::size_t size)
  {
    if (size > bytes_.size() - place_)
      throw std::runtime_error("a frame ends inside an operation");
    const char *start = bytes_.data() + place_;
    place_ += size;
    return start;
  }

  std::vector<char> bytes_;
  std::size_t place_ = 0;
};

/// Collects the answers of a frame.
class Writer
{
public:
  template <typename T> void Add(const T &value)
  {
    const char *start = reinterpret_cast<const char *>(&value);
    bytes.insert(bytes.end(), start, start + sizeof(T));
  }

  void Add(const double *values, std::size_t count)
  {
    const char *start = reinterpret_cast<const char *>(values);
    bytes.insert(bytes.end(), start, start + count * sizeof(double));
  }

  void Add(const std::string &text) { bytes.insert(bytes.end(), text.begin(), text.end()); }

  std::vector<char> bytes;
};

/// A connected Unix socket.
class Channel
{
public:
  /// Connect to the socket that the engine in Python listens on.
  explicit Channel(const std::string &path);
  ~Channel();
  Channel(const Channel &) = delete;
  Channel &operator=(const Channel &) = delete;

  /// Wait for the next frame.
  Reader Receive();

  /// Send a frame: 0 and answers, or 1 and the text of an error.
  void Send(bool failed, const std::vector<char> &bytes);

private:
  void ReadAll(char *to, std::size_t size);

  int socket_;
};
}  // namespace nrp
