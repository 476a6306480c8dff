// SweetHomeMade.java - makes maps/buildings/attic.sh3d by the classes of Sweet Home 3D and saves it as the program does.
// Arguments: TEXTURES.sh3d ATTIC.sh3d; the first one (textures_sh3d.py) lends its pictures and models. Lengths are centimetres, y down.
// Compile and run with the classpath of the program.
import com.eteks.sweethome3d.io.HomeFileRecorder;
import com.eteks.sweethome3d.model.*;
import com.eteks.sweethome3d.tools.URLContent;
import java.io.*;
import java.net.URL;
import java.nio.file.*;
import java.util.*;
import java.util.zip.*;

public class SweetHomeMade {
  static ZipFile lender;
  static File folder;
  static final Home home = new Home(250);

  // A file of the lender's folder, or the files beside it, each in an archive: the program takes contents of one archive for one content.
  static Content entry(String name) throws Exception {
    int slash = name.indexOf('/');
    File file = new File(folder, slash < 0 ? name : name.substring(0, slash) + ".zip");
    if (slash < 0) {
      try (InputStream in = lender.getInputStream(lender.getEntry(name))) { Files.copy(in, file.toPath(), StandardCopyOption.REPLACE_EXISTING); }
      return new URLContent(file.toURI().toURL());
    }
    try (ZipOutputStream out = new ZipOutputStream(new FileOutputStream(file))) {
      for (ZipEntry e : Collections.list(lender.entries())) {
        if (!e.getName().startsWith(name.substring(0, slash + 1))) continue;
        out.putNextEntry(new ZipEntry(e.getName().substring(slash + 1)));
        lender.getInputStream(e).transferTo(out);
      }
    }
    return new URLContent(new URL("jar:" + file.toURI() + "!/" + name.substring(slash + 1)));
  }

  // A picture in its own size, or turned, scaled and moved by shares of its sides.
  static HomeTexture picture(String name, float width, float height, float... how) throws Exception {
    TextureImage image = new CatalogTexture(name, entry(name), width, height);
    return how.length == 0 ? new HomeTexture(image) : new HomeTexture(image, how[0], how[1], how[2], how[3], false, how.length < 5);
  }

  static HomeTexture fitted(String name) throws Exception {
    return new HomeTexture(new CatalogTexture(name, entry(name), 100, 100), 0, 0, 0, 1, true, true);
  }

  static Wall wall(Level level, float x0, float y0, float x1, float y1, float thickness, HomeTexture left, HomeTexture right, float... heights) {
    Wall w = new Wall(x0, y0, x1, y1, thickness, heights.length > 0 ? heights[0] : level.getHeight());
    if (heights.length > 1) w.setHeightAtEnd(heights[1]);
    w.setLeftSideTexture(left);
    w.setRightSideTexture(right);
    home.addWall(w);
    w.setLevel(level);
    return w;
  }

  static void join(Wall... ring) {
    for (int i = 0; i < ring.length; i++) {
      ring[i].setWallAtEnd(ring[(i + 1) % ring.length]);
      ring[(i + 1) % ring.length].setWallAtStart(ring[i]);
    }
  }

  static Room room(Level level, String name, HomeTexture floor, HomeTexture ceiling, float... at) {
    float[][] points = new float[at.length / 2][];
    for (int i = 0; i < points.length; i++) points[i] = new float[] {at[2 * i], at[2 * i + 1]};
    Room r = new Room(points);
    r.setName(name);
    r.setFloorTexture(floor);
    r.setCeilingTexture(ceiling);
    home.addRoom(r);
    r.setLevel(level);
    return r;
  }

  static HomePieceOfFurniture place(HomePieceOfFurniture p, Level level, float x, float y, float degrees) {
    p.setX(x);
    p.setY(y);
    p.setAngle((float) Math.toRadians(degrees));
    home.addPieceOfFurniture(p);
    p.setLevel(level);
    return p;
  }

  static HomePieceOfFurniture piece(String name, String model, float width, float depth, float height) throws Exception {
    return new HomePieceOfFurniture(
        new CatalogPieceOfFurniture(name, entry("label"), entry(model + "/box.obj"), width, depth, height, true, false));
  }

  static HomePieceOfFurniture opening(String name, String model, float width, float height, float up) throws Exception {
    return new HomeDoorOrWindow(new CatalogDoorOrWindow(null, name, null, entry("label"), null, entry(model + "/box.obj"), width, 6, height, up,
        false, 1f, 0f, new Sash[0], null, null, true, null, null));
  }

  static Camera camera(String name, float x, float y, float z, float degrees, float down) {
    Camera c = new Camera(x, y, z, (float) Math.toRadians(degrees), (float) Math.toRadians(down), (float) Math.toRadians(70));
    c.setName(name);
    c.setTime(1718971200000L); // noon of 21 June 2024
    return c;
  }

  static void ground(Level level) throws Exception {
    HomeTexture outside = picture("bricks", 60, 30, .2f, .3f, 0, 1.5f), inside = picture("paper", 40, 80, .5f, .25f, .5f, 1);
    Wall north = wall(level, 0, 0, 700, 0, 30, outside, inside), east = wall(level, 700, 0, 700, 500, 24, outside, picture("grid", 90, 45)),
         south = wall(level, 700, 500, 0, 500, 30, picture("bricks", 60, 30, 0, 0, 0, 1, 0), picture("paper", 40, 80, 0, 0, 0, .8f, 0)),
         west = wall(level, 0, 500, 0, 0, 30, outside, picture("stone", 70, 70, 0, 0, -.7f, 1.2f));
    east.setArcExtent((float) Math.toRadians(50));
    join(north, east, south, west);
    north.setRightSideBaseboard(Baseboard.getInstance(2, 10, null, picture("board", 20, 8, 0, .2f, .2f, 1)));
    east.setRightSideBaseboard(Baseboard.getInstance(1.5f, 12, null, picture("board", 20, 8)));
    Wall between = wall(level, 380, 15, 380, 330, 10, picture("tiles", 30, 30, .1f, .1f, .8f, 1), picture("plaster", 60, 120));
    between.setLeftSideBaseboard(Baseboard.getInstance(1, 7, null, null));
    wall(level, 150, 360, 150, 440, 14, picture("dots", 20, 40), picture("tiles", 15, 15), 110);
    // A room around a corner, and one that ends in the bow of the round wall.
    room(level, "Hall", picture("oak", 120, 30, .3f, .6f, .5f, .9f), picture("plaster", 60, 120, 0, 0, .4f, 1), 15, 15, 375, 15, 375, 335, 690,
        335, 690, 485, 15, 485);
    float[] bow = new float[2 * 14];
    double radius = 250 / Math.sin(Math.toRadians(25)), middle = 700 - radius * Math.cos(Math.toRadians(25));
    for (int i = 0; i < 11; i++) {
      double a = Math.asin(-235 / (radius - 12)) + (Math.asin(85 / (radius - 12)) - Math.asin(-235 / (radius - 12))) * i / 10;
      bow[2 * i] = (float) (middle + (radius - 12) * Math.cos(a));
      bow[2 * i + 1] = (float) (250 + (radius - 12) * Math.sin(a));
    }
    float[][] rest = {{385, 335}, {385, 175}, {385, 15}};
    for (int i = 0; i < 3; i++) System.arraycopy(rest[i], 0, bow, 22 + 2 * i, 2);
    room(level, "Bow room", fitted("plan"), fitted("grid"), bow);
    // Not in the south wall: where a wall begins at a round one, and has an opening, the program starts its picture anew by rounding errors.
    HomePieceOfFurniture door = opening("Front door", "plain", 90, 205, 0);
    door.setModelMaterials(new HomeMaterial[] {new HomeMaterial("skin", null, picture("crate", 80, 80, .1f, .2f, .3f, .6f), null)});
    place(door, level, 0, 400, 90);
    place(opening("Window", "leaf", 140, 110, 90), level, 0, 180, 90);
    place(opening("Window", "leaf", 120, 120, 80), level, 540, 0, 180);
    HomePieceOfFurniture stair = piece("Stairs", "crate", 90, 230, 262);
    stair.setStaircaseCutOutShape("M0,0 v1 h1 v-1 z");
    place(stair, level, 325, 140, 0);
    HomePieceOfFurniture table = piece("Table", "plain", 120, 70, 74);
    table.setTexture(picture("cloth", 40, 20, .2f, .3f, .6f, .8f));
    place(table, level, 560, 200, 25);
    HomePieceOfFurniture chest = piece("Chest", "crate", 60, 45, 50);
    chest.setModelMaterials(new HomeMaterial[] {new HomeMaterial("skin", null, picture("label", 25, 25, .25f, .1f, .4f, .7f), null)});
    place(chest, level, 80, 230, 90);
    HomePieceOfFurniture tilted = piece("Tilted board", "flat", 50, 4, 90);
    tilted.setPitch((float) Math.toRadians(-20));
    tilted.setTexture(picture("cloth", 40, 20, 0, 0, 0, 1, 0));
    place(tilted, level, 600, 450, 180);
  }

  static void attic(Level level) throws Exception {
    HomeTexture outside = picture("bricks", 60, 30), inside = picture("plaster", 60, 120, .3f, .2f, .3f, .7f);
    Wall north = wall(level, 0, 0, 700, 0, 30, outside, inside, 90), east = wall(level, 700, 0, 700, 250, 30, outside, inside, 90, 290),
         east2 = wall(level, 700, 250, 700, 500, 30, outside, inside, 290, 90), south = wall(level, 700, 500, 0, 500, 30, outside, inside, 90),
         west = wall(level, 0, 500, 0, 250, 30, outside, picture("stone", 70, 70, .4f, 0, 0, 1), 90, 290),
         west2 = wall(level, 0, 250, 0, 0, 30, outside, picture("stone", 70, 70, .4f, 0, 0, 1), 290, 90);
    join(north, east, east2, south, west, west2);
    room(level, "Attic", picture("tiles", 30, 30, .2f, .2f, .25f, 1.1f), picture("oak", 120, 30, 0, 0, 1.2f, .8f), 15, 15, 685, 15, 685, 250, 685,
        485, 15, 485, 15, 250);
    place(opening("Gable window", "leaf", 90, 100, 70), level, 700, 250, 90);
    HomePieceOfFurniture cupboard = piece("Cupboard", "leaf", 80, 50, 120);
    place(cupboard, level, 520, 330, 200);
  }

  public static void main(String[] a) throws Exception {
    lender = new ZipFile(a[0]);
    folder = Files.createTempDirectory("home").toFile();
    Level below = new Level("Ground floor", 0, 12, 250), above = new Level("Attic", 262, 12, 290);
    home.addLevel(below);
    home.addLevel(above);
    ground(below);
    attic(above);
    home.getEnvironment().setGroundTexture(picture("lawn", 150, 40, .1f, .7f, .35f, 2));
    home.getEnvironment().setSkyTexture(picture("sky", 100, 100, .3f, 0, 0, 1));
    home.getEnvironment().setAllLevelsVisible(true);
    home.setStoredCameras(Arrays.asList(camera("Hall", 640, 455, 165, 100, 8), camera("Bow room", 420, 300, 165, 245, 12),
        camera("Attic", 60, 400, 420, 250, 5), camera("Garden", -350, 850, 250, 220, 3)));
    ObserverCamera o = home.getObserverCamera();
    o.setX(640);
    o.setY(455);
    o.setZ(165);
    o.setYaw((float) Math.toRadians(100));
    o.setTime(1718971200000L);
    home.getCompass().setTimeZone("Europe/Paris");
    home.getCompass().setLatitude((float) Math.toRadians(48.9));
    home.getCompass().setLongitude((float) Math.toRadians(2.3));
    new HomeFileRecorder(9, false, null, false, true).writeHome(home, a[1]);
    System.exit(0);
  }
}
