// What libHD exports, without a device: its scheduler calls back from a thread of its own and the
// environment says what goes wrong. A plain C interface, as the vendor's is.

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

namespace {

bool told(const char* fault) {
  const char* const text = std::getenv("FAKE_HD");
  return text != nullptr && std::strcmp(text, fault) == 0;
}

struct Fake {
  unsigned (*callback)(void*) = nullptr;
  void* data = nullptr;
  std::thread scheduler;
  std::atomic<bool> running{false};
  bool enabled = false;
  bool open = false;
  bool in_frame = false;
  std::atomic<int> frames{0};
  std::array<double, 3> force{};
  std::array<double, 3> last_force{};  // of the newest frame
};
Fake fake;
thread_local unsigned last_error = 0;  // a stack a thread, as libHD has

}  // namespace

extern "C" {

struct FakeErrorInfo {
  unsigned code;
  int internal_code;
  unsigned handle;
};

unsigned hdInitDevice(const char* name) {
  if (told("absent")) {
    last_error = 0x0302;
    return 0xFFFFFFFF;
  }
  fake.open = true;
  return name != nullptr && std::strcmp(name, "Right") == 0 ? 5 : 3;
}
void hdDisableDevice(unsigned /*handle*/) { fake.open = false; }
void hdMakeCurrentDevice(unsigned /*handle*/) {}
void hdEnable(unsigned what) { fake.enabled = fake.enabled || what == 0x4000; }
unsigned long hdScheduleAsynchronous(unsigned (*callback)(void*), void* data,
                                     unsigned short /*priority*/) {
  fake.callback = callback;
  fake.data = data;
  return 1;
}
void hdUnschedule(unsigned long /*handle*/) { fake.callback = nullptr; }
void hdStartScheduler() {
  if (told("stuck")) {
    last_error = 0x0101;
    return;
  }
  fake.frames = 0;
  fake.running = true;
  fake.scheduler = std::thread([] {
    while (fake.running && fake.callback(fake.data) == 1) {
      std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
  });
}
void hdStopScheduler() {
  fake.running = false;
  if (fake.scheduler.joinable()) fake.scheduler.join();
  fake.force = {};
}
void hdBeginFrame(unsigned /*handle*/) {
  fake.in_frame = true;
  ++fake.frames;
  if (told("lost") && fake.frames > 50) last_error = 0x0303;
}
void hdEndFrame(unsigned /*handle*/) {
  fake.in_frame = false;
  fake.last_force = fake.force;
}
void hdGetDoublev(unsigned what, double* out) {
  if (!fake.in_frame) last_error = 0x0106;
  for (int n = 0; n < 3; ++n) {
    out[n] = what == 0x2050   ? 10.0 * (n + 1) + fake.frames  // mm
             : what == 0x2051 ? 100.0 * (n + 1)               // mm/s
                              : std::nan("");
  }
}
void hdGetIntegerv(unsigned what, int* out) { *out = what == 0x2000 ? 2 : 0; }
void hdSetDoublev(unsigned what, const double* in) {
  if (what != 0x2700 || !fake.in_frame || !fake.enabled) last_error = 0x0100;
  for (std::size_t n = 0; n < 3; ++n) fake.force[n] = in[n];
}
FakeErrorInfo hdGetError() {
  const FakeErrorInfo out{last_error, 0, 3};
  last_error = 0;
  return out;
}

// For the tests alone.
int fake_frames() { return fake.frames; }
double fake_last_force(int axis) { return fake.last_force[static_cast<std::size_t>(axis)]; }
int fake_open() { return fake.open ? 1 : 0; }
}
