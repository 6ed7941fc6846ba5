#pragma once
/// Real exams, which are no part of the project: a test of one is skipped, and counted so, on a
/// machine that has none of them. Where they are, it runs: one that is missing then is a failure.

#include <cstdlib>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

namespace beatlas::test {

/// Their folder: BEATLAS_SHARED_DATA, else shared/data beside the sources.
[[nodiscard]] inline std::filesystem::path real_exams() {
  const char* root = std::getenv("BEATLAS_SHARED_DATA");
  return root != nullptr && *root != '\0' ? root : BEATLAS_SHARED_DATA;
}

[[nodiscard]] inline std::filesystem::path real_exam(const std::string& name) {
  return real_exams() / name;
}

}  // namespace beatlas::test

/// The first line of a test of the real exam `name`.
#define BEATLAS_NEEDS_REAL_EXAM(name)                                                     \
  if (!std::filesystem::exists(beatlas::test::real_exams() / "exams.json")) {             \
    GTEST_SKIP() << "the real exams of " << beatlas::test::real_exams()                   \
                 << " are not on this machine (set BEATLAS_SHARED_DATA to their folder)"; \
  }                                                                                       \
  ASSERT_TRUE(std::filesystem::is_directory(beatlas::test::real_exam(name)))              \
      << (name) << " is missing beside the other real exams"
