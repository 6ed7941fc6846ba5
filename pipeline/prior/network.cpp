#include "pipeline/prior/network.h"

#include <array>
#include <cctype>
#include <mutex>
#include <new>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/dnn.hpp>

#include "runtime/base/error.h"

namespace beatlas::prior {
namespace {

/// The layer that OpenCV's words are about, if they name one. The words themselves run over several
/// lines and speak of its own sources.
std::string layer_of(const cv::Exception& exception) {
  // "Node [Conv@ai.onnx]:(name) parse error: ..."
  constexpr std::string_view kNode = "Node [";
  const std::size_t at = exception.err.find(kNode);
  if (at == std::string::npos) return {};
  const std::size_t begin = at + kNode.size();
  std::size_t end = begin;
  while (end < exception.err.size() &&
         std::isalnum(static_cast<unsigned char>(exception.err[end]))) {
    ++end;
  }
  return " for its layer " + exception.err.substr(begin, end - begin);
}

[[noreturn]] void refuse(const std::string& what, const cv::Exception& exception) {
  if (exception.code == cv::Error::StsNoMem) throw std::bad_alloc();
  throw_invalid("OpenCV's dnn cannot " + what + layer_of(exception) +
                "; export the network with layers it knows (opset 11) and for any height and width "
                "that are multiples of \"multiple\"");
}

std::string shape_text(const cv::Mat& blob) {
  std::string out;
  for (int axis = 0; axis < blob.dims; ++axis) {
    out += (axis > 0 ? " x " : "") + std::to_string(blob.size[axis]);
  }
  return out;
}

class Loop : public cv::ParallelLoopBody {
 public:
  explicit Loop(const std::function<void()>& work) : work_(work) {}
  void operator()(const cv::Range&) const override { work_(); }

 private:
  const std::function<void()>& work_;
};

class QuietLog {
 public:
  QuietLog() : before_(cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT)) {}
  ~QuietLog() { cv::utils::logging::setLogLevel(before_); }
  QuietLog(const QuietLog&) = delete;
  QuietLog& operator=(const QuietLog&) = delete;

 private:
  cv::utils::logging::LogLevel before_;
};

}  // namespace

struct Network::Held {
  cv::dnn::Net net;
  int channels = 0;
  int outputs = 0;
  cv::Mat logits;
};

Network::Network(std::span<const std::byte> onnx, const ModelCard& card)
    : held_(std::make_unique<Held>()) {
  held_->channels = static_cast<int>(card.channels.size());
  held_->outputs = static_cast<int>(card.outputs.size());
  try {
    held_->net = cv::dnn::readNetFromONNX(reinterpret_cast<const char*>(onnx.data()), onnx.size());
    if (held_->net.empty()) throw_invalid("it holds no network; export it again");
    held_->net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    held_->net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
  } catch (const cv::Exception& exception) {
    refuse("read it", exception);
  }
}

Network::~Network() = default;
Network::Network(Network&&) noexcept = default;

std::span<const float> Network::run(std::span<const float> input, int width, int height) {
  const std::array<int, 4> sizes{1, held_->channels, height, width};
  // OpenCV takes no pointer to const; it copies what it is given.
  const cv::Mat blob(4, sizes.data(), CV_32F, const_cast<float*>(input.data()));
  try {
    held_->net.setInput(blob);
    held_->logits = held_->net.forward();
  } catch (const cv::Exception& exception) {
    refuse("run it on " + shape_text(blob), exception);
  }
  const cv::Mat& logits = held_->logits;
  const std::array<int, 4> wanted{1, held_->outputs, height, width};
  bool fits = logits.dims == 4 && logits.type() == CV_32F && logits.isContinuous();
  for (int axis = 0; fits && axis < 4; ++axis) {
    fits = logits.size[axis] == wanted[static_cast<std::size_t>(axis)];
  }
  if (!fits) {
    throw_invalid("the network gives " + shape_text(logits) + " for an input of " +
                  shape_text(blob) + ", where " + std::to_string(held_->outputs) +
                  " outputs of the same height and width were promised; mend \"outputs\" or export "
                  "another network");
  }
  return {logits.ptr<float>(), logits.total()};
}

struct NetworkPool::Free {
  std::mutex mutex;
  std::vector<Network> networks;
};

NetworkPool::NetworkPool(const Model& model) : model_(model), free_(std::make_unique<Free>()) {}
NetworkPool::~NetworkPool() = default;

void NetworkPool::with(const std::function<void(Network&)>& use) {
  std::vector<Network> mine;
  {
    const std::lock_guard lock(free_->mutex);
    if (!free_->networks.empty()) {
      mine.push_back(std::move(free_->networks.back()));
      free_->networks.pop_back();
    }
  }
  if (mine.empty()) mine.emplace_back(model_.onnx(), model_.card());
  use(mine.front());
  const std::lock_guard lock(free_->mutex);
  free_->networks.push_back(std::move(mine.front()));
}

void with_quiet_opencv(const std::function<void()>& work) {
  const QuietLog quiet;
  // OpenCV runs a loop inside a loop of its own on the thread that it meets: so there is no need
  // to set its number of threads, which is one for the whole process. What it does with the loop
  // is the same work in the same pieces.
  cv::parallel_for_(cv::Range(0, 1), Loop(work));
}

}  // namespace beatlas::prior
