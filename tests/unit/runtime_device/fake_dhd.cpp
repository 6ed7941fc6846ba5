// What libdhd exports, without a device; the environment says what goes wrong (FAKE_DHD), where its
// handle is (FAKE_DHD_AT, three numbers [m]) and which file keeps what it was sent (FAKE_DHD_LOG).

#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {
bool told(const char* fault) {
  const char* const text = std::getenv("FAKE_DHD");
  return text != nullptr && std::strcmp(text, fault) == 0;
}
std::FILE* log() {
  static std::FILE* const file = [] {
    const char* const name = std::getenv("FAKE_DHD_LOG");
    return name != nullptr ? std::fopen(name, "w") : nullptr;
  }();
  return file;
}
int reads = 0;
int opened = 0;
std::array<double, 3> force{};
}  // namespace

extern "C" {

int dhdOpen() {
  if (told("absent")) return -1;
  reads = 0;
  ++opened;
  return 2;
}
int dhdClose(char id) {
  --opened;
  if (log() != nullptr) {
    (void)std::fputs("closed\n", log());
    (void)std::fflush(log());
  }
  return id == 2 ? 0 : -1;
}
int dhdEnableForce(unsigned char on, char id) { return on == 1 && id == 2 ? 0 : -1; }
int dhdGetPosition(double* x, double* y, double* z, char id) {
  ++reads;
  if (id != 2 || (told("lost") && reads > 20)) return -1;
  *x = 0.01;
  *y = 0.02;
  *z = 0.03;
  const char* const at = std::getenv("FAKE_DHD_AT");
  if (at != nullptr) (void)std::sscanf(at, "%lf %lf %lf", x, y, z);
  if (told("blind") && reads >= 20 && reads < 23) *x = std::nan("");
  return 0;
}
int dhdGetLinearVelocity(double* x, double* y, double* z, char id) {
  *x = 0.1;
  *y = 0.2;
  *z = 0.3;
  return id == 2 ? 0 : -1;
}
int dhdGetButton(int index, char id) { return (index == 0 || index == 3) && id == 2 ? 1 : 0; }
int dhdSetForce(double x, double y, double z, char id) {
  force = {x, y, z};
  if (log() != nullptr) {
    (void)std::fprintf(log(), "%.6f\n", std::sqrt(x * x + y * y + z * z));
    (void)std::fflush(log());
  }
  return id == 2 ? 0 : -1;
}
const char* dhdErrorGetLastStr() { return "no device found"; }

// For the tests alone.
double fake_force(int axis) { return force[static_cast<std::size_t>(axis)]; }
int fake_opened() { return opened; }
}
