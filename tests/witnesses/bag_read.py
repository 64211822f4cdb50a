"""Reads a ROS 2 bag by rosbags, with the definitions that it holds: `PYTHON bag_read.py BAG`. Prints what was read as JSON."""

import json
import sys
from pathlib import Path

from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

if __name__ == "__main__":
    types, image, angles, ends, messages = get_typestore(Stores.EMPTY), [], [], [0.0, 0.0], 0
    with Reader(Path(sys.argv[1])) as reader:
        for connection in reader.connections:
            types.register(get_types_from_msg(connection.msgdef.data, connection.msgtype))
        for connection, _, content in reader.messages():
            message = types.deserialize_cdr(content, connection.msgtype)
            messages += 1
            if connection.topic == "/radar/data":
                image += [each.echoes.tolist() for each in message.intensities]
                angles += [message.angle_start + k * message.angle_increment for k in range(len(message.intensities))]
                ends = [message.range_min, message.range_max]
        count = len(reader.connections)
    print(json.dumps({"image": image, "angles": angles, "range": ends, "messages": messages, "types": count}))
