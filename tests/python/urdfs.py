"""Small robot descriptions, and a mesh to go with them, that tests share."""

# The corners of the unit cube, in Wavefront's format.
CUBE = "".join(f"v {x} {y} {z}\n" for x in (0, 1) for y in (0, 1) for z in (0, 1))


def one_joint(inside="", *, kind="continuous", link=""):
    """Link "a", joint "j" about z with these elements inside, and link "b" with those."""
    return (
        f'<robot name="one"><link name="a"/><link name="b">{link}</link>'
        f'<joint name="j" type="{kind}"><parent link="a"/><child link="b"/>{inside}'
        '<axis xyz="0 0 1"/></joint></robot>'
    )


def two_wheels(mimic, elbow=""):
    """Link "a", joint "one", link "b", joint "two", which mimics "one" so, and link "c"."""
    return (
        '<robot name="two"><link name="a"/><link name="b"/><link name="c"/>'
        '<joint name="one" type="continuous"><parent link="a"/><child link="b"/>'
        '<axis xyz="0 0 1"/></joint><joint name="two" type="continuous"><parent link="b"/>'
        f'<child link="c"/>{elbow}<axis xyz="0 0 1"/><mimic joint="one" {mimic}/></joint></robot>'
    )


def with_mesh(file, scale="1 1 1"):
    """A robot of one joint whose moving link is a mesh."""
    mesh = f'<mesh filename="{file}" scale="{scale}"/>'
    return one_joint(link=f"<collision><geometry>{mesh}</geometry></collision>")
