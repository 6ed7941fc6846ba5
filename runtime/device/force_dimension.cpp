#include "runtime/device/force_dimension.h"

#include <cmath>
#include <vector>

#include "runtime/base/error.h"
#include "runtime/device/pacer.h"

namespace beatlas::device {
namespace {

constexpr double kPatienceS = 0.1;  // of answers with errors

// dhd: x towards the user, y right, z up. Ours: right, up, towards the user.
Vec3 from_dhd(const Vec3& dhd) { return {dhd.y(), dhd.z(), dhd.x()}; }
Vec3 to_dhd(const Vec3& our) { return {our.z(), our.x(), our.y()}; }

}  // namespace

ForceDimensionDevice::ForceDimensionDevice(const ForceDimensionOptions& options)
    : library_(one_or(options.library, {"libdhd.so", "libdhd.so.3"}), "the SDK of Force Dimension"),
      options_(options) {
  if (!(options.rate_hz >= 100 && options.rate_hz <= 8000)) {
    throw_invalid("a Force Dimension device's rate must be from 100 to 8000 ticks a second");
  }
#define BEATLAS_BIND(function) library_.bind(#function, dhd_.function)
  BEATLAS_BIND(dhdOpen);
  BEATLAS_BIND(dhdClose);
  BEATLAS_BIND(dhdEnableForce);
  BEATLAS_BIND(dhdGetPosition);
  BEATLAS_BIND(dhdGetLinearVelocity);
  BEATLAS_BIND(dhdGetButton);
  BEATLAS_BIND(dhdSetForce);
  BEATLAS_BIND(dhdErrorGetLastStr);
#undef BEATLAS_BIND
  const int id = dhd_.dhdOpen();
  if (id < 0) {
    const char* const why = dhd_.dhdErrorGetLastStr();
    throw Error(ErrorCode::Machine, std::string("no Force Dimension device can be opened (") +
                                        (why != nullptr ? why : "no reason is given") +
                                        "); plug it in and switch it on, or use another --device");
  }
  id_ = static_cast<char>(id);
}

ForceDimensionDevice::~ForceDimensionDevice() {
  drop_force();
  (void)dhd_.dhdClose(id_);
}

void ForceDimensionDevice::drop_force() noexcept { (void)dhd_.dhdSetForce(0, 0, 0, id_); }

RunReport ForceDimensionDevice::run(const ServoFn& servo, std::stop_token stop) {
  Pacer pacer(Pace::RealTime, options_.rate_hz);
  (void)dhd_.dhdEnableForce(1, id_);
  RunReport report;
  double sound_s = 0;  // when the device last answered well
  Vec3 last_m = Vec3::Zero();
  while (!stop.stop_requested()) {
    DeviceState state;
    state.time_s = pacer.next();
    Vec3 x = Vec3::Zero();
    Vec3 v = Vec3::Zero();
    state.valid = dhd_.dhdGetPosition(&x[0], &x[1], &x[2], id_) >= 0 &&
                  dhd_.dhdGetLinearVelocity(&v[0], &v[1], &v[2], id_) >= 0 && x.allFinite() &&
                  v.allFinite();
    if (state.valid) last_m = from_dhd(x);
    state.position_m = last_m;
    state.velocity_m_s = state.valid ? from_dhd(v) : Vec3::Zero();
    for (int n = 0; n < kButtons; ++n) {
      if (dhd_.dhdGetButton(n, id_) > 0) state.buttons |= 1U << n;
    }
    const Vec3 wanted_n = servo(state);
    const Vec3 force_n = state.valid && wanted_n.allFinite() ? to_dhd(wanted_n) : Vec3::Zero();
    const bool sent = dhd_.dhdSetForce(force_n.x(), force_n.y(), force_n.z(), id_) >= 0;
    report = pacer.report();
    if (state.valid && sent) sound_s = state.time_s;
    if (state.time_s - sound_s > kPatienceS) {
      drop_force();
      throw Error(ErrorCode::Machine,
                  "the Force Dimension device was lost; check its cable and start again, or use "
                  "another --device");
    }
  }
  drop_force();
  return report;
}

}  // namespace beatlas::device
