/// beatlas-play with a picture, as it is called.

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

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

// A window on a server of its own, which is ended while the window is seen.
TEST_F(Command, ALostDisplayIsOneSentenceAndMachineTrouble) {
  std::array<int, 2> told{};
  ASSERT_EQ(pipe(told.data()), 0);
  const pid_t server = fork();
  if (server == 0) {
    const int nowhere = open("/dev/null", O_RDWR);
    dup2(nowhere, STDERR_FILENO);
    execlp("Xvfb", "Xvfb", "-displayfd", std::to_string(told[1]).c_str(), "-screen", "0",
           "1280x1024x24", "-noreset", static_cast<char*>(nullptr));
    _exit(127);
  }
  close(told[1]);
  std::array<char, 16> number{};
  ASSERT_GT(read(told[0], number.data(), number.size() - 1), 0);
  close(told[0]);
  std::string display(":");
  display += std::to_string(std::atoi(number.data()));

  const std::string text = file("lost.txt");
  const pid_t play = fork();
  if (play == 0) {
    setenv("DISPLAY", display.c_str(), 1);
    setenv("XDG_CONFIG_HOME", folder_->path().c_str(), 1);
    const int to = open(text.c_str(), O_CREAT | O_WRONLY, 0600);
    dup2(to, STDOUT_FILENO);
    dup2(to, STDERR_FILENO);
    const std::string heart = file("heart.beatlas");
    execl(BEATLAS_PLAY, BEATLAS_PLAY, heart.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  EXPECT_TRUE(test::window_is_seen(display));
  kill(server, SIGKILL);
  waitpid(server, nullptr, 0);
  int status = 0;
  bool ended = false;
  for (int n = 0; n < 200 && !ended; ++n) {
    ended = waitpid(play, &status, WNOHANG) == play;
    if (!ended) usleep(50'000);
  }
  if (!ended) {
    kill(play, SIGKILL);
    waitpid(play, nullptr, 0);
  }
  ASSERT_TRUE(ended);
  std::ifstream stream(text);
  const std::string said{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_TRUE(WIFEXITED(status)) << "by signal " << WTERMSIG(status) << '\n' << said;
  EXPECT_EQ(WEXITSTATUS(status), 5) << said;
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
  EXPECT_EQ(said.rfind("beatlas-play: the display is gone", 0), 0U) << said;
}

TEST_F(Command, SessionsAndHelpNeedNoViewer) {
  EXPECT_EQ(call("--help").code, 0);
  EXPECT_EQ(call("").code, 2);
  EXPECT_EQ(call("probe --help").code, 0);
  EXPECT_EQ(call(file("felt.beatlas") + " --headless --fast --seconds 0.2").code, 0);
}

}  // namespace
}  // namespace beatlas::viewer
