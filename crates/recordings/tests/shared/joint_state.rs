//! Messages of ROS 2 about joints, as their writers put them.

/// What stands in a log of them.
pub const SCHEMA: &str = "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n\
    float64[] effort\n================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n";

/// Little-endian CDR of a `sensor_msgs/msg/JointState`: its stamp in ns, the names of joints, their positions,
/// velocities and efforts.
pub fn joint_state(stamp: u64, names: &[&str], lists: [&[f64]; 3]) -> Vec<u8> {
    let mut data = vec![0, 1, 0, 0];
    let align = |data: &mut Vec<u8>, to: usize| {
        data.resize((data.len() - 4).next_multiple_of(to) + 4, 0);
    };
    let length = |data: &mut Vec<u8>, length: usize| {
        align(data, 4);
        data.extend((length as u32).to_le_bytes());
    };
    let text = |data: &mut Vec<u8>, text: &str| {
        length(data, text.len() + 1);
        data.extend(text.as_bytes());
        data.push(0);
    };
    data.extend(((stamp / 1_000_000_000) as i32).to_le_bytes());
    data.extend(((stamp % 1_000_000_000) as u32).to_le_bytes());
    text(&mut data, "base");
    length(&mut data, names.len());
    names.iter().for_each(|name| text(&mut data, name));
    for list in lists {
        length(&mut data, list.len());
        if !list.is_empty() {
            align(&mut data, 8);
        }
        list.iter().for_each(|value| data.extend(value.to_le_bytes()));
    }
    data
}
