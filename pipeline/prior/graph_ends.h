#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace beatlas::prior {

/// What an ONNX file says of itself. OpenCV does not: it takes a convolution of one channel that is
/// given four for one in four groups, without a word.
struct GraphEnds {
  /// [input or output][axis] sizes; 0: whatever the caller gives. Weights are no inputs.
  std::vector<std::vector<long long>> inputs;
  std::vector<std::vector<long long>> outputs;
};

/// Reads the few fields of ONNX's ModelProto that tell.
/// @throws Error{InvalidInput} without the file's name: cut, or no ONNX
[[nodiscard]] GraphEnds graph_ends(std::span<const std::byte> onnx);

}  // namespace beatlas::prior
