// What libdhd exports, without a device; the environment says what goes wrong.

#include <array>
#include <cstdlib>
#include <cstring>

namespace {
bool told(const char* fault) {
  const char* const text = std::getenv("FAKE_DHD");
  return text != nullptr && std::strcmp(text, fault) == 0;
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
  return id == 2 ? 0 : -1;
}
int dhdEnableForce(unsigned char on, char id) { return on == 1 && id == 2 ? 0 : -1; }
int dhdGetPosition(double* x, double* y, double* z, char id) {
  ++reads;
  if (id != 2 || (told("lost") && reads > 20)) return -1;
  *x = 0.01;
  *y = 0.02;
  *z = 0.03;
  return 0;
}
int dhdGetLinearVelocity(double* x, double* y, double* z, char id) {
  *x = 0.1;
  *y = 0.2;
  *z = 0.3;
  return id == 2 ? 0 : -1;
}
int dhdGetButton(int index, char id) { return index == 0 && id == 2 ? 1 : 0; }
int dhdSetForce(double x, double y, double z, char id) {
  force = {x, y, z};
  return id == 2 ? 0 : -1;
}
const char* dhdErrorGetLastStr() { return "no device found"; }

// For the tests alone.
double fake_force(int axis) { return force[static_cast<std::size_t>(axis)]; }
int fake_opened() { return opened; }
}
