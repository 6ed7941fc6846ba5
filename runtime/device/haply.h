#pragma once
#include <chrono>
#include <string>

#include "runtime/device/device.h"
#include "runtime/device/web_socket.h"

namespace beatlas::device {

struct HaplyOptions {
  std::string host = "localhost";
  int port = 10001;            ///< of Haply's service
  std::string device_id = {};  ///< empty: the first one listed
  double connect_s = 2;        ///< [s] 0.01..60: for the connection and the first frame
  double reply_s = 0.1;        ///< [s] 0.005..5: without a reply for longer the device is lost
  double patience_s = 10;      ///< [s] 0..3600: how long a lost device is waited for
};

/// Haply Inverse3 through Haply's local service: JSON over a WebSocket. Exactly one reply comes for
/// a message, so what is sent sets the rate. Its axes are right, away from the user, up.
///
/// Not tested on hardware: a server of the tests speaks the protocol as reference/haptics.md tells.
class HaplyDevice final : public Device {
 public:
  /// Connects and reads the first frame. @throws Error{InvalidInput} if an option is out of range;
  /// Error{Machine} if the service does not answer, or lists no such device.
  explicit HaplyDevice(const HaplyOptions& options);
  ~HaplyDevice() override;

  [[nodiscard]] std::string name() const override { return "haply"; }
  /// While the device is lost the servo is told so (`valid` false) and the connection is tried
  /// again; when `patience_s` is over, Error{Machine}.
  RunReport run(const ServoFn& servo, std::stop_token stop) override;
  void drop_force() noexcept override;
  [[nodiscard]] const std::string& device_id() const { return device_id_; }

 private:
  void open();
  /// Position and velocity of our device in a frame; false if it is not in it or it is damaged.
  [[nodiscard]] bool read_state(std::string_view frame, DeviceState& state) const noexcept;
  [[nodiscard]] bool send_force(const Vec3& force_n, bool first) noexcept;
  /// Waits for the device to come back. @throws Error{Machine} when patience is over.
  void wait_for_device(const ServoFn& servo, const std::stop_token& stop,
                       std::chrono::steady_clock::time_point start, RunReport& report);

  HaplyOptions options_;
  WebSocket socket_;
  std::string device_id_;
  DeviceState last_;
  bool first_ = true;  // of a connection: the message that names the session
};

}  // namespace beatlas::device
