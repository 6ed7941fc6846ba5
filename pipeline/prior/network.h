#pragma once
/// Networks that run, one a worker.

#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "pipeline/prior/model.h"

namespace beatlas::prior {

/// A network of OpenCV's dnn, made of a model's bytes.
class Network {
 public:
  /// @throws Error{InvalidInput} without the file's name
  Network(std::span<const std::byte> onnx, const ModelCard& card);
  ~Network();
  Network(Network&&) noexcept;

  /// @param input [channel][row][column]; @return logits [output][row][column], until the next call
  /// @throws Error{InvalidInput} without the file's name
  [[nodiscard]] std::span<const float> run(std::span<const float> input, int width, int height);

 private:
  struct Held;
  std::unique_ptr<Held> held_;
};

/// Hands out networks to whoever runs at once, and makes as many as that takes.
class NetworkPool {
 public:
  explicit NetworkPool(const Model& model);
  ~NetworkPool();
  /// Calls `use` with a network that nobody else has meanwhile.
  void with(const std::function<void(Network&)>& use);

 private:
  struct Free;
  const Model& model_;
  std::unique_ptr<Free> free_;
};

/// Runs `work` with OpenCV as this room wants it: its own loops do not part work among threads of
/// theirs, because ours do that, and it says nothing on stderr. Afterwards it is as before.
void with_quiet_opencv(const std::function<void()>& work);

}  // namespace beatlas::prior
