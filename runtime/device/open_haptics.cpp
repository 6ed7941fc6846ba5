#include "runtime/device/open_haptics.h"

#include <array>
#include <thread>
#include <vector>

#include "runtime/base/error.h"

namespace beatlas::device {
namespace {

using Clock = std::chrono::steady_clock;

// HD/hdDefines.h of OpenHaptics.
constexpr unsigned kCurrentButtons = 0x2000;
constexpr unsigned kCurrentPosition = 0x2050;  // [mm]
constexpr unsigned kCurrentVelocity = 0x2051;  // [mm/s]
constexpr unsigned kCurrentForce = 0x2700;     // [N]
constexpr unsigned kForceOutput = 0x4000;
constexpr unsigned kInvalidHandle = 0xFFFFFFFF;
constexpr unsigned kSuccess = 0;
constexpr unsigned kCallbackContinue = 1;
constexpr unsigned short kHighestPriority = 0xFFFF;

constexpr int kMostErrors = 100;  // a tenth of a second at 1 kHz

}  // namespace

OpenHapticsDevice::OpenHapticsDevice(const OpenHapticsOptions& options)
    : library_(one_or(options.library, {"libHD.so", "libHD.so.3", "libHD.so.3.4"}),
               "OpenHaptics of 3D Systems") {
#define BEATLAS_BIND(function) library_.bind(#function, hd_.function)
  BEATLAS_BIND(hdInitDevice);
  BEATLAS_BIND(hdDisableDevice);
  BEATLAS_BIND(hdMakeCurrentDevice);
  BEATLAS_BIND(hdEnable);
  BEATLAS_BIND(hdStartScheduler);
  BEATLAS_BIND(hdStopScheduler);
  BEATLAS_BIND(hdScheduleAsynchronous);
  BEATLAS_BIND(hdUnschedule);
  BEATLAS_BIND(hdBeginFrame);
  BEATLAS_BIND(hdEndFrame);
  BEATLAS_BIND(hdGetDoublev);
  BEATLAS_BIND(hdGetIntegerv);
  BEATLAS_BIND(hdSetDoublev);
  BEATLAS_BIND(hdGetError);
#undef BEATLAS_BIND
  handle_ = hd_.hdInitDevice(options.device_name.empty() ? nullptr : options.device_name.c_str());
  const ErrorInfo error = hd_.hdGetError();
  if (error.code != kSuccess || handle_ == kInvalidHandle) {
    throw Error(ErrorCode::Machine,
                "the 3D Systems device cannot be opened (HD error " + std::to_string(error.code) +
                    "); plug it in and calibrate it with the vendor's tool, or use another "
                    "--device");
  }
}

OpenHapticsDevice::~OpenHapticsDevice() { hd_.hdDisableDevice(handle_); }

unsigned OpenHapticsDevice::called(void* self) {
  static_cast<OpenHapticsDevice*>(self)->tick();
  return kCallbackContinue;
}

void OpenHapticsDevice::tick() noexcept {
  hd_.hdBeginFrame(handle_);
  std::array<double, 3> position_mm{};
  std::array<double, 3> velocity_mm_s{};
  int buttons = 0;
  hd_.hdGetDoublev(kCurrentPosition, position_mm.data());
  hd_.hdGetDoublev(kCurrentVelocity, velocity_mm_s.data());
  hd_.hdGetIntegerv(kCurrentButtons, &buttons);
  DeviceState state;
  state.time_s = std::chrono::duration<double>(Clock::now() - start_).count();
  state.position_m = 1e-3 * Vec3(position_mm.data());
  state.velocity_m_s = 1e-3 * Vec3(velocity_mm_s.data());
  state.buttons = static_cast<std::uint32_t>(buttons);
  state.valid = hd_.hdGetError().code == kSuccess;
  errors_ = state.valid ? 0 : errors_ + 1;
  Vec3 force_n = (*servo_)(state);
  if (dropped_.exchange(false, std::memory_order_acq_rel) || !state.valid || !force_n.allFinite()) {
    force_n.setZero();
  }
  hd_.hdSetDoublev(kCurrentForce, force_n.data());
  hd_.hdEndFrame(handle_);
  ++report_.ticks;
  // A force that was refused is an error of the next frame; each frame begins with a clean slate.
  if (state.valid && hd_.hdGetError().code != kSuccess) ++errors_;
  if (errors_ >= kMostErrors) lost_.store(true, std::memory_order_release);
}

RunReport OpenHapticsDevice::run(const ServoFn& servo, std::stop_token stop) {
  servo_ = &servo;
  start_ = Clock::now();
  report_ = {};
  errors_ = 0;
  lost_ = false;
  hd_.hdMakeCurrentDevice(handle_);
  hd_.hdEnable(kForceOutput);
  const unsigned long scheduled = hd_.hdScheduleAsynchronous(&called, this, kHighestPriority);
  hd_.hdStartScheduler();
  const ErrorInfo started = hd_.hdGetError();
  while (started.code == kSuccess && !stop.stop_requested() &&
         !lost_.load(std::memory_order_acquire)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  // Once the scheduler stands still no force is on the motors.
  hd_.hdStopScheduler();
  hd_.hdUnschedule(scheduled);
  if (started.code != kSuccess) {
    throw Error(ErrorCode::Machine, "the 3D Systems device's scheduler does not start (HD error " +
                                        std::to_string(started.code) +
                                        "); end other programs that use the device");
  }
  if (lost_) {
    throw Error(ErrorCode::Machine,
                "the 3D Systems device was lost; check its cable and start again, or use another "
                "--device");
  }
  return report_;
}

}  // namespace beatlas::device
