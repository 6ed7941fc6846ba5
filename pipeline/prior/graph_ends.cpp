#include "pipeline/prior/graph_ends.h"

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "runtime/base/error.h"

namespace beatlas::prior {
namespace {

// Field numbers of onnx.proto.
constexpr std::uint64_t kModelGraph = 7;
constexpr std::uint64_t kGraphInitializer = 5;
constexpr std::uint64_t kGraphInput = 11;
constexpr std::uint64_t kGraphOutput = 12;
constexpr std::uint64_t kTensorName = 8;
constexpr std::uint64_t kValueName = 1;
constexpr std::uint64_t kValueType = 2;
constexpr std::uint64_t kTypeTensor = 1;
constexpr std::uint64_t kTensorShape = 2;
constexpr std::uint64_t kShapeAxis = 1;
constexpr std::uint64_t kAxisSize = 1;

[[noreturn]] void refuse_other() {
  throw_invalid("it is no ONNX file; export the network as ONNX, and name that file");
}

/// Fields of one message of protobuf's wire format.
class Fields {
 public:
  explicit Fields(std::string_view bytes) : rest_(bytes) {}

  std::uint64_t number = 0;
  std::uint64_t value = 0;  ///< of a field that is one number
  std::string_view part;    ///< of a field that is text or a message

  bool next() {
    if (rest_.empty()) return false;
    const std::uint64_t key = varint();
    number = key >> 3U;
    value = 0;
    part = {};
    if (number == 0) refuse_other();
    switch (key & 7U) {
      case 0:
        value = varint();
        break;
      case 1:
        (void)take(8);
        break;
      case 2:
        part = take(varint());
        break;
      case 5:
        (void)take(4);
        break;
      default:
        refuse_other();
    }
    return true;
  }

 private:
  std::uint64_t varint() {
    std::uint64_t out = 0;
    for (unsigned shift = 0; shift < 64; shift += 7) {
      const auto byte = static_cast<unsigned char>(take(1).front());
      out |= static_cast<std::uint64_t>(byte & 0x7FU) << shift;
      if (byte < 0x80U) return out;
    }
    refuse_other();
  }
  std::string_view take(std::uint64_t count) {
    if (count > rest_.size()) {
      throw_invalid("it is no ONNX file, or one that is cut; copy or export it again");
    }
    const std::string_view out = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return out;
  }

  std::string_view rest_;
};

struct Value {
  std::string name;
  std::vector<long long> sizes;
};

std::vector<long long> sizes_of(std::string_view shape) {
  std::vector<long long> out;
  for (Fields axis(shape); axis.next();) {
    if (axis.number != kShapeAxis) continue;
    long long size = 0;
    for (Fields field(axis.part); field.next();) {
      if (field.number == kAxisSize) size = static_cast<long long>(field.value);
    }
    out.push_back(size);
  }
  return out;
}

Value value_of(std::string_view message) {
  Value out;
  for (Fields field(message); field.next();) {
    if (field.number == kValueName) out.name = field.part;
    if (field.number != kValueType) continue;
    for (Fields type(field.part); type.next();) {
      if (type.number != kTypeTensor) continue;
      for (Fields tensor(type.part); tensor.next();) {
        if (tensor.number == kTensorShape) out.sizes = sizes_of(tensor.part);
      }
    }
  }
  return out;
}

}  // namespace

GraphEnds graph_ends(std::span<const std::byte> onnx) {
  const std::string_view bytes(reinterpret_cast<const char*>(onnx.data()), onnx.size());
  std::string_view graph;
  for (Fields model(bytes); model.next();) {
    if (model.number == kModelGraph) graph = model.part;
  }
  if (graph.empty()) refuse_other();
  std::set<std::string, std::less<>> weights;
  std::vector<Value> inputs;
  GraphEnds out;
  for (Fields field(graph); field.next();) {
    if (field.number == kGraphInput) inputs.push_back(value_of(field.part));
    if (field.number == kGraphOutput) out.outputs.push_back(value_of(field.part).sizes);
    if (field.number != kGraphInitializer) continue;
    for (Fields tensor(field.part); tensor.next();) {
      if (tensor.number == kTensorName) weights.emplace(tensor.part);
    }
  }
  for (Value& input : inputs) {  // before ONNX 1.4 weights stood among the inputs
    if (weights.count(input.name) == 0) out.inputs.push_back(std::move(input.sizes));
  }
  return out;
}

}  // namespace beatlas::prior
