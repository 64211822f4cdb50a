// Runs the class Radar of halo_radar, the ROS driver, without ROS. Words on standard input: a key and a value of its commands, as
// "gain 33" or "status standby", "image FILE", "quit"; says what changes in its state, a line each.
#include "halo_radar.h"
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iostream>
using namespace simrad_halo_radar;
static std::mutex mutex;
static double Now() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }
static void Say(const std::string &what, const std::string &value) {
  printf("%.4f %s %s\n", Now(), what.c_str(), value.c_str()), fflush(stdout);
}
class Reader : public Radar {
 public:
  unsigned char image[2048][1024] = {};
  int metres = 0;
  Reader(AddressSet const &of) : Radar(of) { startThreads(); }

 protected:
  std::map<std::string, std::string> m_said;
  void processData(std::vector<Scanline> const &lines) override {
    std::lock_guard<std::mutex> lock(mutex);
    if (!metres) Say("spoke", std::to_string(int(lines.front().angle)));
    for (auto const &each : lines) {
      memcpy(image[int(std::lround(each.angle / 360.0 * 2048)) % 2048], each.intensities.data(), 1024);
      metres = each.range;
    }
  }
  void stateUpdated() override {
    for (auto const &each : m_state)
      if (m_said[each.first] != each.second) Say(each.first, m_said[each.first] = each.second);
  }
};
int main() {
  Say("started", "1");
  std::vector<AddressSet> found = scan();
  if (found.empty()) return 1;
  Say("found", "1");
  static Reader radar(found[0]);
  for (std::string word, value; std::cin >> word >> value && word != "quit";) {
    Say("say-" + word, value);
    if (word != "image") radar.sendCommand(word, value);
    else {
      std::lock_guard<std::mutex> lock(mutex);
      std::ofstream(value, std::ios::binary).write((const char *)radar.image, sizeof radar.image);
      Say("samples", "1024"), Say("metres", std::to_string(radar.metres));
    }
  }
  _Exit(0);
}
