/// beatlas-play with a picture, as it is called.

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "runtime/device/hardware.h"
#include "runtime/viewer/heart_frame.h"
#include "runtime/viewer/stills.h"
#include "tests/viewer/ellipsoid.h"
#include "tests/viewer/seen_window.h"

namespace beatlas::viewer {
namespace {

struct Called {
  int code = -1;
  std::string text;  // both streams
};

// Without a display, whatever the test runs on.
Called call(const std::string& words) {
  const std::string line = "env -u DISPLAY '" BEATLAS_PLAY "' " + words + " 2>&1";
  FILE* pipe = popen(line.c_str(), "r");
  Called called;
  std::array<char, 512> bytes;
  std::size_t got = 0;
  while ((got = fread(bytes.data(), 1, bytes.size(), pipe)) > 0) {
    called.text.append(bytes.data(), got);
  }
  const int status = pclose(pipe);
  called.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return called;
}

// The size that a PNG's header says.
std::array<unsigned, 2> png_size(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::array<unsigned char, 24> head{};
  stream.read(reinterpret_cast<char*>(head.data()), head.size());
  if (!stream || head[1] != 'P' || head[2] != 'N' || head[3] != 'G') return {0, 0};
  const auto number = [&](std::size_t at) {
    return (unsigned{head[at]} << 24U) | (unsigned{head[at + 1]} << 16U) |
           (unsigned{head[at + 2]} << 8U) | unsigned{head[at + 3]};
  };
  return {number(16), number(20)};
}

class Command : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<test::TemporaryFolder>();
    pack::write_package(file("heart.beatlas"), test::sample_content(6, 30, 2, 4));
    pack::PackageContent touched = test::sample_content(6, 30, 2, 4);
    touched.surfaces.clear();
    touched.volume.reset();
    pack::write_package(file("felt.beatlas"), touched);
    std::ofstream(file("foreign.beatlas")) << "no package at all";
    std::filesystem::copy_file(file("heart.beatlas"), file("broken.beatlas"));
    std::filesystem::resize_file(file("broken.beatlas"),
                                 std::filesystem::file_size(file("heart.beatlas")) / 2);
  }
  static void TearDownTestSuite() { folder_.reset(); }
  static std::string file(const std::string& name) { return (folder_->path() / name).string(); }
  static inline std::unique_ptr<test::TemporaryFolder> folder_;
};

TEST_F(Command, WritesAPictureWithoutADisplay) {
  const Called called = call(file("heart.beatlas") + " --screenshot " + file("a.png") +
                             " --phase es --view four-chamber --cut axial --size 320x240");
  EXPECT_EQ(called.code, 0) << called.text;
  EXPECT_EQ(called.text, "");
  EXPECT_EQ(png_size(file("a.png")), (std::array<unsigned, 2>{320, 240}));
}

TEST_F(Command, ColoursTheWallOfAPackageThatHasItsMap) {
  for (const char* colour : {"thickness", "stiffness --preset anterior_infarct", "segments"}) {
    const Called called = call(file("heart.beatlas") + " --screenshot " + file("c.png") +
                               " --size 320x240 --colour " + colour);
    EXPECT_EQ(called.code, 0) << colour << called.text;
  }
  pack::PackageContent plain = test::sample_content(6, 30, 2, 2);
  plain.maps.clear();
  pack::write_package(file("plain.beatlas"), plain);
  const Called none =
      call(file("plain.beatlas") + " --screenshot " + file("d.png") + " --colour thickness");
  EXPECT_EQ(none.code, 3);
  EXPECT_NE(none.text.find("no map of the LV's wall"), std::string::npos) << none.text;
  EXPECT_EQ(call(file("heart.beatlas") + " --screenshot x.png --colour beauty").code, 2);
}

TEST_F(Command, PressesAndPlots) {
  const Called called = call(file("heart.beatlas") + " --screenshot " + file("b.png") +
                             " --press-mm 4 --plots --volume blood --size 400x200");
  EXPECT_EQ(called.code, 0) << called.text;
  EXPECT_EQ(png_size(file("b.png")), (std::array<unsigned, 2>{400, 200}));
}

TEST_F(Command, RecordsABeat) {
  const Called called =
      call(file("heart.beatlas") + " --record " + file("beat") + " --frames 3 --size 128x96");
  EXPECT_EQ(called.code, 0) << called.text;
  for (const char* name : {"beat/frame_0000.png", "beat/frame_0001.png", "beat/frame_0002.png"}) {
    EXPECT_EQ(png_size(file(name)), (std::array<unsigned, 2>{128, 96})) << name;
  }
  EXPECT_FALSE(std::filesystem::exists(file("beat/frame_0003.png")));
}

// With nothing but the tool in the picture, what differs from frame to frame is what is felt.
TEST_F(Command, RecordsWhatIsFeltAtEachMoment) {
  const Called called =
      call(file("heart.beatlas") + " --record " + file("felt") +
           " --frames 3 --size 256x192 --press-mm 4 --model patch --no-caption --opacity heart=0"
           " --opacity lv_blood=0 --opacity rv_blood=0");
  EXPECT_EQ(called.code, 0) << called.text;
  const auto frame = [&](int n) {
    std::ifstream stream(file("felt/frame_000" + std::to_string(n) + ".png"), std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(stream), {});
  };
  EXPECT_FALSE(frame(0).empty());
  EXPECT_TRUE(frame(0) != frame(1));
  EXPECT_TRUE(frame(1) != frame(2));
  EXPECT_TRUE(frame(2) != frame(0));
}

TEST_F(Command, TroubleIsOneSentenceAndTheRightCode) {
  const std::string shot = " --screenshot " + file("none.png");
  const std::vector<std::pair<int, std::string>> cases{
      {3, file("missing.beatlas") + shot},
      {3, file("foreign.beatlas") + shot},
      {3, file("broken.beatlas") + shot},
      {3, file("felt.beatlas") + shot},  // nothing to draw
      {3, file("missing.beatlas")},      // said before a window opens
      {5, file("heart.beatlas")},        // no display for a window
      {5, file("heart.beatlas") + " --screenshot " + file("nowhere/a.png")},
      {5, file("heart.beatlas") + " --record " + file("foreign.beatlas") + "/b"},
      {2, file("heart.beatlas") + shot + " --phase never"},
      {2, file("heart.beatlas") + shot + " --view upwards"},
      {2, file("heart.beatlas") + shot + " --size 10"},
      {2, file("heart.beatlas") + shot + " --opacity heart"},
      {3, file("heart.beatlas") + shot + " --opacity aorta=1"},
      {2, file("heart.beatlas") + shot + " --record x"},
      {2, file("heart.beatlas") + shot + " --cut axial --cut-plane 0 0 0 1 0 0"},
      {2, file("heart.beatlas") + shot + " --cut-plane 0 0 0 0 0 0"},
      {2, file("heart.beatlas") + " --what"},
      {2, "--screenshot a.png"},
      {2, file("heart.beatlas") + " --screenshot " + file("a.jpg")},
  };
  for (const auto& [code, words] : cases) {
    const Called called = call(words);
    EXPECT_EQ(called.code, code) << words << '\n' << called.text;
    EXPECT_EQ(std::count(called.text.begin(), called.text.end(), '\n'), 1) << called.text;
    EXPECT_EQ(called.text.rfind("beatlas-play: ", 0), 0U) << called.text;
  }
  EXPECT_FALSE(std::filesystem::exists(file("none.png")));
  EXPECT_FALSE(std::filesystem::exists(file("none.png.part")));
}

// A window of a program of its own on a server of its own; both are ended with it.
class SeenProgram {
 public:
  /// @param words after the program's name  @param text file for both its streams
  SeenProgram(std::vector<std::string> words, const std::string& text,
              const std::filesystem::path& config) {
    std::array<int, 2> told{};
    if (pipe(told.data()) != 0) return;
    server_ = fork();
    if (server_ == 0) {
      const int nowhere = open("/dev/null", O_RDWR);
      dup2(nowhere, STDERR_FILENO);
      execlp("Xvfb", "Xvfb", "-displayfd", std::to_string(told[1]).c_str(), "-screen", "0",
             "1280x1024x24", "-noreset", static_cast<char*>(nullptr));
      _exit(127);
    }
    close(told[1]);
    std::array<char, 16> number{};
    (void)!read(told[0], number.data(), number.size() - 1);
    close(told[0]);
    display_ = ":";
    display_ += std::to_string(std::atoi(number.data()));
    play_ = fork();
    if (play_ != 0) return;
    setenv("DISPLAY", display_.c_str(), 1);
    setenv("XDG_CONFIG_HOME", config.c_str(), 1);
    const int to = open(text.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600);
    dup2(to, STDOUT_FILENO);
    dup2(to, STDERR_FILENO);
    words.insert(words.begin(), BEATLAS_PLAY);
    std::vector<char*> argv;
    argv.reserve(words.size() + 1);
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    execv(BEATLAS_PLAY, argv.data());
    _exit(127);
  }
  ~SeenProgram() {
    for (const pid_t process : {play_, server_}) {
      if (process <= 0) continue;
      kill(process, SIGKILL);
      waitpid(process, nullptr, 0);
    }
  }
  SeenProgram(const SeenProgram&) = delete;
  SeenProgram& operator=(const SeenProgram&) = delete;

  [[nodiscard]] bool seen() const { return test::window_is_seen(display_); }
  void send(int signal) const { kill(play_, signal); }
  void end_display() {
    kill(server_, SIGKILL);
    waitpid(server_, nullptr, 0);
    server_ = -1;
  }
  /// -1 if a signal ended it, -2 if it goes on.
  int code() {
    int status = 0;
    for (int n = 0; n < 400; ++n) {
      if (waitpid(play_, &status, WNOHANG) == play_) {
        play_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
      }
      usleep(50'000);
    }
    return -2;
  }

 private:
  pid_t server_ = -1;
  pid_t play_ = -1;
  std::string display_;
};

std::string text_of(const std::string& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// The server is ended while the window is seen.
TEST_F(Command, ALostDisplayIsOneSentenceAndMachineTrouble) {
  SeenProgram play({file("heart.beatlas")}, file("lost.txt"), folder_->path());
  EXPECT_TRUE(play.seen());
  play.end_display();
  const int code = play.code();
  const std::string said = text_of(file("lost.txt"));
  EXPECT_EQ(code, 5) << said;
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
  EXPECT_EQ(said.rfind("beatlas-play: the display is gone", 0), 0U) << said;
}

TEST_F(Command, AWindowThatIsToldToEndLeavesItsDeviceWithoutForceAndClosed) {
  const OpenedHeart heart = open_heart(file("heart.beatlas"));
  const HeartFrame frame = heart_frame(*heart.atlas);
  const Vec3 outward = free_wall_direction(frame, heart.field->centre_mm()).normalized();
  const Affine from_device = device::workspace_from_hardware(
      heart.atlas->manifest().workspace_from_lps, Vec3::Zero(), outward, 0);
  // Some millimetres below the surface, from the middle 20 mm outside of it; libdhd's x is towards
  // the user, its y right, its z up.
  const Vec3 ours_m = -1e-3 * 25 * (from_device.linear().transpose() * outward);
  std::ostringstream at;
  at << ours_m.z() << ' ' << ours_m.x() << ' ' << ours_m.y();
  setenv("FAKE_DHD_AT", at.str().c_str(), 1);
  setenv("FAKE_DHD_LOG", file("sent.txt").c_str(), 1);
  SeenProgram play({file("heart.beatlas"), "--device", "dhd", "--device-library", FAKE_DHD},
                   file("ended.txt"), folder_->path());
  unsetenv("FAKE_DHD_AT");
  unsetenv("FAKE_DHD_LOG");
  EXPECT_TRUE(play.seen());
  const auto last_n = [&] {  // the last force that is written whole
    const std::string sent = text_of(file("sent.txt"));
    if (sent.size() < 40) return 0.0;
    return std::strtod(sent.c_str() + sent.rfind('\n', sent.size() - 12) + 1, nullptr);
  };
  for (int n = 0; n < 400 && last_n() < 0.1; ++n) usleep(50'000);
  EXPECT_GT(last_n(), 0.1);
  play.send(SIGTERM);
  EXPECT_EQ(play.code(), 5);
  const std::string said = text_of(file("ended.txt"));
  EXPECT_EQ(said.rfind("beatlas-play: interrupted; the force is off", 0), 0U) << said;
  const std::string sent = text_of(file("sent.txt"));
  EXPECT_TRUE(sent.ends_with("\n0.000000\nclosed\n")) << sent.substr(sent.size() - 60);
}

TEST_F(Command, FingersAndCavitiesAreAskedForSensibly) {
  const std::string heart = file("felt.beatlas");
  const std::string fingers = " --fingers " BEATLAS_SOURCE_DIR "/samples/fingers_window.json";
  for (const std::string& words :
       {heart + " --screenshot x.png" + fingers, heart + " --device simulated" + fingers,
        std::string(fingers), heart + " --valve", heart + " --inside lv_blood --model patch",
        heart + " --screenshot x.png --inside lv_blood", heart + " --inside lv_myocardium"}) {
    EXPECT_EQ(call(words).code, 2) << words;
  }
  const std::string exercise =
      " --exercise " BEATLAS_SOURCE_DIR "/samples/exercises/06_any.json --session " + file("ses");
  for (const std::string& words :
       {heart + " --window", heart + " --window --exercise none.json", " --window" + exercise,
        heart + " --window --inside lv_blood" + exercise,
        heart + " --window --model patch" + exercise, heart + " --headless --window" + exercise}) {
    EXPECT_EQ(call(words).code, 2) << words;
  }
  EXPECT_EQ(call(heart + " --window --exercise none.json --session s").code, 3);
  EXPECT_EQ(call(file("heart.beatlas") + " --window" + exercise).code, 5) << "no display";
  EXPECT_EQ(call(heart + " --fingers none.json").code, 3);
  const std::string low = " --case " BEATLAS_SOURCE_DIR "/samples/cases/low_pressure.case.json";
  for (const std::string& words :
       {low, heart + low + " --preset low_pressure", heart + low + " --parameters p.json",
        heart + low + " --screenshot x.png", heart + low + " --model proxy",
        heart + low + " --window" + exercise}) {
    EXPECT_EQ(call(words).code, 2) << words;
  }
  EXPECT_EQ(call(heart + " --parameters none.json").code, 3);
  EXPECT_EQ(call(file("heart.beatlas") + low).code, 5) << "no display";
  const Called mouse = call(heart + " --headless --fast" + fingers);
  EXPECT_EQ(mouse.code, 3);
  EXPECT_NE(mouse.text.find("/fingers/0/device may be mouse"), std::string::npos) << mouse.text;
  const Called away = call(heart + " --inside rv_blood");
  EXPECT_EQ(away.code, 3) << away.text;
  EXPECT_NE(away.text.find("rv_blood"), std::string::npos) << away.text;
  // All is well but that there is no display.
  EXPECT_EQ(call(file("heart.beatlas") + fingers).code, 5);
}

TEST_F(Command, WithoutAWordThereIsTheWindow) {
  const Called alone = call("");
  EXPECT_EQ(alone.code, 5) << alone.text;  // there is no display
  EXPECT_NE(alone.text.find("there is no display for a window"), std::string::npos) << alone.text;
}

TEST_F(Command, SessionsAndHelpNeedNoViewer) {
  EXPECT_EQ(call("--help").code, 0);
  EXPECT_EQ(call("--headless").code, 2);
  EXPECT_EQ(call("probe --help").code, 0);
  EXPECT_EQ(call(file("felt.beatlas") + " --headless --fast --seconds 0.2").code, 0);
}

}  // namespace
}  // namespace beatlas::viewer
