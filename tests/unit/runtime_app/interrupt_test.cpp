/// beatlas-play ended from outside while it drives a device: as its own process, by its exit status
/// and by what the device was sent.

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

namespace {

using namespace std::chrono_literals;

class Interrupted : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("beatlas_interrupt_" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override {
    if (child_ > 0) {
      ::kill(child_, SIGKILL);
      ::waitpid(child_, nullptr, 0);
    }
    std::filesystem::remove_all(folder_);
  }
  [[nodiscard]] std::string file(const char* name) const { return (folder_ / name).string(); }

  void start(std::vector<std::string> words) {
    words.insert(words.begin(), {BEATLAS_PLAY, BEATLAS_GOLDEN_PACKAGE, "--headless"});
    child_ = ::fork();
    if (child_ != 0) return;
    ::setenv("FAKE_DHD_LOG", file("sent").c_str(), 1);
    ::setenv("FAKE_DHD_AT", "0 -0.024 0", 1);  // 24 mm to the patient's right: 4 mm deep
    if (std::freopen(file("out").c_str(), "w", stdout) == nullptr) std::_Exit(1);
    if (std::freopen(file("err").c_str(), "w", stderr) == nullptr) std::_Exit(1);
    std::vector<char*> argv;
    argv.reserve(words.size() + 1);
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    ::execv(BEATLAS_PLAY, argv.data());
    std::_Exit(127);
  }
  [[nodiscard]] std::vector<std::string> lines(const char* name) const {
    std::ifstream stream(file(name));
    std::vector<std::string> out;
    for (std::string line; std::getline(stream, line);) out.push_back(line);
    return out;
  }
  [[nodiscard]] std::string text(const char* name) const {
    std::ifstream stream(file(name));
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  template <class Condition>
  static bool wait_for(Condition condition) {
    for (int n = 0; n < 2000; ++n) {
      if (condition()) return true;
      std::this_thread::sleep_for(10ms);
    }
    return false;
  }
  /// Whether SIGTERM is the program's own by now.
  [[nodiscard]] bool listens() const {
    std::ifstream status("/proc/" + std::to_string(child_) + "/status");
    for (std::string line; std::getline(status, line);) {
      if (line.rfind("SigBlk:", 0) != 0) continue;
      return ((std::stoull(line.substr(7), nullptr, 16) >> (SIGTERM - 1)) & 1U) != 0;
    }
    return false;
  }
  /// -1 if a signal ended it.
  int ended() {
    int status = 0;
    const bool gone = wait_for([&] { return ::waitpid(child_, &status, WNOHANG) == child_; });
    EXPECT_TRUE(gone) << "it goes on";
    if (!gone) return -2;
    child_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  std::filesystem::path folder_;
  pid_t child_ = -1;
};

TEST_F(Interrupted, ADeviceIsLeftWithoutForceAndClosed) {
  for (const int number : {SIGTERM, SIGINT}) {
    start({"--device", "dhd", "--device-library", FAKE_DHD, "--seconds", "600", "--trace",
           file("trace.csv"), "--json"});
    const auto felt = [&] {
      const auto sent = lines("sent");
      return sent.size() > 2 && std::strtod(sent[sent.size() - 2].c_str(), nullptr) > 0.1;
    };
    ASSERT_TRUE(wait_for(felt)) << "it is touched; " << text("err");
    ::kill(child_, number);
    EXPECT_EQ(ended(), 5);
    const auto sent = lines("sent");
    ASSERT_GT(sent.size(), 3U);
    EXPECT_EQ(sent.back(), "closed");
    EXPECT_EQ(std::strtod(sent[sent.size() - 2].c_str(), nullptr), 0) << "the last force";
    EXPECT_NE(text("err").find("interrupted; the force is off"), std::string::npos) << text("err");
    // What was asked for is there.
    EXPECT_NE(text("out").find("\"ticks\""), std::string::npos);
    EXPECT_GT(lines("trace.csv").size(), 50U);
    std::filesystem::remove(file("sent"));
  }
}

TEST_F(Interrupted, ASimulatedHandEndsAsWell) {
  start({"--seconds", "600", "--ticks", file("ticks.txt")});
  ASSERT_TRUE(wait_for([&] { return listens(); }));
  ::kill(child_, SIGINT);
  const int code = ended();
  EXPECT_EQ(code, 5) << text("err");
  EXPECT_FALSE(lines("ticks.txt").empty());
}

}  // namespace
