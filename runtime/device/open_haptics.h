#pragma once
#include <atomic>
#include <chrono>
#include <string>

#include "runtime/device/device.h"
#include "runtime/device/shared_library.h"

namespace beatlas::device {

struct OpenHapticsOptions {
  std::string library = {};      ///< file to load; empty: libHD.so
  std::string device_name = {};  ///< as the vendor's tool named it; empty: the default device
};

/// 3D Systems Touch, PHANToM: libHD of OpenHaptics, loaded when it is wanted. The vendor's
/// scheduler calls the servo. Its axes are right, up, towards the user; mm and mm/s.
///
/// Not tested on hardware: a library of the tests exports the same functions.
class OpenHapticsDevice final : public Device {
 public:
  /// Opens the device. @throws Error{Machine} if library or device is not there.
  explicit OpenHapticsDevice(const OpenHapticsOptions& options);
  ~OpenHapticsDevice() override;

  [[nodiscard]] std::string name() const override { return "3ds"; }
  [[nodiscard]] int buttons() const override { return 4; }
  /// @throws Error{Machine} if the device answers with errors for a tenth of a second.
  RunReport run(const ServoFn& servo, std::stop_token stop) override;
  /// The next frame sends zero. A servo that hangs holds up the vendor's scheduler itself: no
  /// function of libHD may be called beside it, and the device's own timeout must take the force
  /// off.
  void drop_force() noexcept override { dropped_.store(true, std::memory_order_release); }

 private:
  // HDErrorInfo, which hdGetError returns by value.
  struct ErrorInfo {
    unsigned code;
    int internal_code;
    unsigned handle;
  };
  using Callback = unsigned(void*);
  struct Functions {
    unsigned (*hdInitDevice)(const char*);
    void (*hdDisableDevice)(unsigned);
    void (*hdMakeCurrentDevice)(unsigned);
    void (*hdEnable)(unsigned);
    void (*hdStartScheduler)();
    void (*hdStopScheduler)();
    unsigned long (*hdScheduleAsynchronous)(Callback*, void*, unsigned short);
    void (*hdUnschedule)(unsigned long);
    void (*hdBeginFrame)(unsigned);
    void (*hdEndFrame)(unsigned);
    void (*hdGetDoublev)(unsigned, double*);
    void (*hdGetIntegerv)(unsigned, int*);
    void (*hdSetDoublev)(unsigned, const double*);
    ErrorInfo (*hdGetError)();
  };

  static unsigned called(void* self);
  void tick() noexcept;

  SharedLibrary library_;
  Functions hd_{};
  unsigned handle_ = 0;
  const ServoFn* servo_ = nullptr;
  std::chrono::steady_clock::time_point start_;
  RunReport report_;
  int errors_ = 0;  // in a row
  std::atomic<bool> lost_{false};
  std::atomic<bool> dropped_{false};
};

}  // namespace beatlas::device
