/* The descriptor that the device sends. Written by write_layout.py: do not edit. */
#ifndef FC_LAYOUT_H
#define FC_LAYOUT_H

#define FC_FIRMWARE_VERSION "0.1.0"

#define FC_LAYOUT \
    "{\"channels\":[{\"name\":\"piezo_index\",\"kind\":\"piezo\",\"finger\":0,\"unit\":\"V\",\"scale\":0.0001007080078125,\"offset\":16384.0,\"taxel\":null}," \
    "{\"name\":\"piezo_thumb\",\"kind\":\"piezo\",\"finger\":1,\"unit\":\"V\",\"scale\":0.0001007080078125,\"offset\":16384.0,\"taxel\":null}," \
    "{\"name\":\"force_index_0\",\"kind\":\"force\",\"finger\":0,\"unit\":\"V\",\"scale\":0.0001007080078125,\"offset\":0.0,\"taxel\":0}," \
    "{\"name\":\"force_index_1\",\"kind\":\"force\",\"finger\":0,\"unit\":\"V\",\"scale\":0.0001007080078125,\"offset\":0.0,\"taxel\":1}," \
    "{\"name\":\"force_index_2\",\"kind\":\"force\",\"finger\":0,\"unit\":\"V\",\"scale\":0.0001007080078125,\"offset\":0.0,\"taxel\":2}," \
    "{\"name\":\"force_index_3\",\"kind\":\"force\",\"finger\":0,\"unit\":\"V\",\"scale\":0.0001007080078125,\"offset\":0.0,\"taxel\":3}," \
    "{\"name\":\"force_index_4\",\"kind\":\"force\",\"finger\":0,\"unit\":\"V\",\"scale\":0.0001007080078125,\"offset\":0.0,\"taxel\":4}," \
    "{\"name\":\"force_index_5\",\"kind\":\"force\",\"finger\":0,\"unit\":\"V\",\"scale\":0.0001007080078125,\"offset\":0.0,\"taxel\":5}," \
    "{\"name\":\"force_thumb_0\",\"kind\":\"force\",\"finger\":1,\"unit\":\"V\",\"scale\":0.0001007080078125,\"offset\":0.0,\"taxel\":0}," \
    "{\"name\":\"force_thumb_1\",\"kind\":\"force\",\"finger\":1,\"unit\":\"V\",\"scale\":0.0001007080078125,\"offset\":0.0,\"taxel\":1}," \
    "{\"name\":\"force_thumb_2\",\"kind\":\"force\",\"finger\":1,\"unit\":\"V\",\"scale\":0.0001007080078125,\"offset\":0.0,\"taxel\":2}," \
    "{\"name\":\"force_thumb_3\",\"kind\":\"force\",\"finger\":1,\"unit\":\"V\",\"scale\":0.0001007080078125,\"offset\":0.0,\"taxel\":3}," \
    "{\"name\":\"force_thumb_4\",\"kind\":\"force\",\"finger\":1,\"unit\":\"V\",\"scale\":0.0001007080078125,\"offset\":0.0,\"taxel\":4}," \
    "{\"name\":\"force_thumb_5\",\"kind\":\"force\",\"finger\":1,\"unit\":\"V\",\"scale\":0.0001007080078125,\"offset\":0.0,\"taxel\":5}," \
    "{\"name\":\"strip_index\",\"kind\":\"strip\",\"finger\":0,\"unit\":\"\",\"scale\":1.0,\"offset\":0.0,\"taxel\":null}," \
    "{\"name\":\"strip_thumb\",\"kind\":\"strip\",\"finger\":1,\"unit\":\"\",\"scale\":1.0,\"offset\":0.0,\"taxel\":null}]," \
    "\"rate\":4936.0,\"smoothing_alpha\":0.5}"

/* Volts of a reading are (reading - offset) * scale. */
#define FC_PIEZO_OFFSET 16384.0
#define FC_PIEZO_SCALE 0.0001007080078125
#define FC_FORCE_OFFSET 0.0
#define FC_FORCE_SCALE 0.0001007080078125

/* board and source are string literals; source is "real", "twin" or "synthetic". */
#define FC_DESCRIPTOR_TEXT(board, source) \
    "{\"firmware\":\"firstcontact " FC_FIRMWARE_VERSION " (" board ")\"," \
    "\"sensor\":\"piezo + 3x2 Velostat, two fingertips\",\"hand\":\"\"," \
    "\"source\":\"" source "\",\"layout\":" FC_LAYOUT "}"

#endif
