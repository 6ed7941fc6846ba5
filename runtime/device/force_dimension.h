#pragma once
#include <atomic>
#include <string>

#include "runtime/device/device.h"
#include "runtime/device/shared_library.h"

namespace beatlas::device {

struct ForceDimensionOptions {
  std::string library;    ///< file to load; empty: libdhd.so
  double rate_hz = 1000;  ///< [1/s] 100..8000
};

/// Force Dimension, Novint Falcon: libdhd, loaded when it is wanted; a loop of our own. Its axes
/// are towards the user, right, up; SI.
///
/// Not tested on hardware: a library of the tests exports the same functions.
class ForceDimensionDevice final : public Device {
 public:
  /// Opens the first device. @throws Error{InvalidInput} for a rate out of range; Error{Machine} if
  /// library or device is not there.
  explicit ForceDimensionDevice(const ForceDimensionOptions& options);
  ~ForceDimensionDevice() override;

  [[nodiscard]] std::string name() const override { return "dhd"; }
  [[nodiscard]] int buttons() const override { return kButtons; }
  /// @throws Error{Machine} if the device answers with errors for a tenth of a second.
  RunReport run(const ServoFn& servo, std::stop_token stop) override;
  /// libdhd may be called from any thread.
  void drop_force() noexcept override;

 private:
  static constexpr int kButtons = 4;  ///< that are asked for; a device may have fewer

  struct Functions {
    int (*dhdOpen)();
    int (*dhdClose)(char);
    int (*dhdEnableForce)(unsigned char, char);
    int (*dhdGetPosition)(double*, double*, double*, char);
    int (*dhdGetLinearVelocity)(double*, double*, double*, char);
    int (*dhdGetButton)(int, char);
    int (*dhdSetForce)(double, double, double, char);
    const char* (*dhdErrorGetLastStr)();
  };

  SharedLibrary library_;
  ForceDimensionOptions options_;
  Functions dhd_{};
  char id_ = -1;
};

}  // namespace beatlas::device
