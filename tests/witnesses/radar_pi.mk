# The plugin radar_pi, from its sources RADAR with their submodule opencpn-libs; WX: libraries, INCLUDES: options.
SRC := $(filter-out %/Kalman-test.cpp,$(shell find $(RADAR)/src $(RADAR)/opencpn-libs/nmea0183/src $(RADAR)/opencpn-libs/wxJSON/src \
  -name "*.cpp"))
OBJ := $(patsubst $(RADAR)/%.cpp,obj/%.o,$(SRC))
libradar_pi.so: $(OBJ)
	g++ -shared -o $@ $^ $(shell wx-config --libs $(WX)) -lGL -lGLU
obj/%.o: $(RADAR)/%.cpp
	@mkdir -p $(dir $@)
	g++ -w -O1 -fPIC -std=c++14 -DUSE_GL -DocpnUSE_GL -D__OCPN__ -DHAVE_CONFIG_H -I. $(INCLUDES) $(shell wx-config --cxxflags $(WX)) \
	  -c -o $@ $<
