/// Overflows an int and goes on, if it may.
#include <climits>
#include <cstdio>

int main(int argc, char**) {
  const int sum = INT_MAX + argc;
  std::printf("went on to %d\n", sum);
  return 0;
}
